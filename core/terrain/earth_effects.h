// Earth curvature and atmospheric refraction, for photos whose ground coordinates are those of a
// map: east and north on a plane, heights above a curved surface.
//
// In a near-vertical photo taken at height H above the ground (principal distance c, radius r from
// the nadir) curvature moves an image point towards the nadir by H r^3 / (2 R c^2), refraction away
// from it by K (r + r^3 / c^2) (Manual of Photogrammetry; Kraus, Photogrammetry). The linear term
// is inseparable from the flying height; the cubic term has the form of a radial distortion k1. So
// a camera looking through air at a curved earth is a camera with another lens, and everything that
// projects with it is consistent.
#pragma once

#include <map>
#include <string>

#include "core/geometry/camera.h"

namespace orient {

// Mean radius; what an ellipsoid and its latitudes change of it is below 0.4 % of the effect.
inline constexpr double kEarthRadius_m = 6371000;

inline constexpr double kFilmPixel_mm = 0.025;  // where it is not known how it was scanned

enum class EarthMode { kAuto, kFlat, kCurved };
const std::map<std::string, EarthMode>& EarthModes();  // by the names that users give
std::string Name(EarthMode mode);

// Bertram's K for the standard atmosphere (ARDC 1959), rad: a ray at the zenith angle t arrives
// bent by K tan(t). Heights above sea level, metres, up to 15 km.
double RefractionOfStandardAtmosphere(double flying_m, double ground_m);

// The k1 of both effects together, per mm^2; negative: inwards. Heights above sea level, metres.
double EarthDistortion(double principal_distance_mm, double flying_m, double ground_m);

// The largest displacement of this k1 within the frame that no flying height absorbs, mm.
double LargestUnabsorbed(const Camera& camera, double k1);

// The camera with its lens changed by the two effects; as it is where the mode says flat, or says
// auto and they stay below a tenth of a pixel (a digital camera's own; of film, of
// `film_pixel_mm`).
Camera WithEarthEffects(const Camera& camera, EarthMode mode, double flying_m, double ground_m,
                        double film_pixel_mm = kFilmPixel_mm);

// The camera with k1 r^3 added to its lens distortion (r from the principal point, mm) and
// recorded in its earth_k1.
Camera WithEarth(const Camera& camera, double k1);

// What of the camera's earth_k1 is curvature: in a Cartesian ground system it must not be there.
double CurvatureOf(const Camera& camera, double ground_m);

}  // namespace orient
