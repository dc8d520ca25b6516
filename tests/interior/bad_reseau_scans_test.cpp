// What bad scans of cameras with a reseau get, simulated: a reseau fits itself when it is moved by
// a mesh, turned or mirrored, so that what is cut off, hidden or not on the scan could go
// unnoticed.
#include "interior/orientation/reseau.h"
#include "tests/interior/bad_scans.h"
#include "tests/support/film_frame.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

class SlowBadReseauScans : public BadScans {};

// A square of crosses in the picture, `meshes` on every side of the middle one.
CameraFile Crosses(int meshes, double mesh_mm, const CrossElement& cross, double frame_mm) {
  CameraFile file = RingCamera(0.47 * frame_mm, frame_mm);
  file.camera.name = "reseau";
  file.fiducials.clear();
  MarkDrawing drawing;
  drawing.elements = {cross};
  drawing.background = MarkBackground::kImage;
  file.marks["cross"] = drawing;
  for (int row = -meshes; row <= meshes; ++row)
    for (int col = -meshes; col <= meshes; ++col)
      file.fiducials.push_back({std::to_string(file.fiducials.size() + 1),
                                Vector2d(mesh_mm * col, mesh_mm * row), "cross", std::nullopt});
  return file;
}

constexpr double kDensePixel_mm = 0.04, kWidePixel_mm = 0.08;

CameraFile Dense() { return Crosses(3, 8, {2, 0.08, 0, 0}, 60); }
// As the dense one, with a mesh of 7.8 mm.
CameraFile Denser() { return Crosses(3, 7.8, {2, 0.08, 0, 0}, 60); }
CameraFile Wide() { return Crosses(2, 13, {3, 0.15, 0, 0}, 70); }

// Four fiducial marks in the corners besides the crosses.
CameraFile WithFiducials() {
  CameraFile file = Wide();
  file.camera.name = "reseau and fiducial marks";
  for (const Fiducial& corner : RingCamera(32.5, 70).fiducials)
    file.fiducials.push_back({"F" + corner.id, corner.position_mm, "corner", std::nullopt});
  return file;
}

std::vector<KnownScan> Reseaus(unsigned seed, bool marks = true) {
  return {
      SimulatedOf("dense reseau", Dense(), kDensePixel_mm, seed, marks),
      SimulatedOf("wide reseau", Wide(), kWidePixel_mm, seed + 1, marks),
      SimulatedOf("reseau and fiducial marks", WithFiducials(), kWidePixel_mm, seed + 2, marks)};
}

double MeshPixels(const KnownScan& known) {
  return known.name == "dense reseau" ? 8 / kDensePixel_mm : 13 / kWidePixel_mm;
}

TEST_F(SlowBadReseauScans, AsTheyAre) {
  for (const KnownScan& known : Reseaus(1)) Try("as it is", Plain(known));
}

TEST_F(SlowBadReseauScans, NoMarkAtAll) {
  for (const KnownScan& known : Reseaus(11, false)) {
    Trial trial = Plain(known);
    trial.no_answer = true;
    Try("rebate without crosses", trial);
    trial.scan.image = RenderTexture(known.scan.image.width, known.scan.image.height, 77);
    Try("texture alone", trial);
    trial.dpi = Vector2d(0, 0);
    Try("texture alone, no tag", trial);
  }
}

// By a row of crosses, and by two.
TEST_F(SlowBadReseauScans, CutOff) {
  for (const KnownScan& known : Reseaus(21))
    for (const double meshes : {1.3, 2.3})
      for (const auto& [where, margins] : Cuts(static_cast<int>(meshes * MeshPixels(known))))
        Try("cut off at " + where + " by meshes: " + std::to_string(meshes),
            With(known, Cut(known.scan, margins)));
}

TEST_F(SlowBadReseauScans, UpsideDownMirroredAndNegative) {
  for (const KnownScan& known : Reseaus(31))
    for (const auto& [how, trial] : Ways(known)) Try(how, trial);
}

TEST_F(SlowBadReseauScans, OtherCamerasFiles) {
  const std::vector<KnownScan> scans = Reseaus(41);
  std::vector<CameraFile> others = {Dense(), Denser(), Wide(), WithFiducials(),
                                    LibraryCamera("hasselblad_mk_reseau")};
  for (const KnownScan& known : scans)
    for (const CameraFile& other : others) {
      if (other.camera.name == known.camera.camera.name &&
          other.fiducials.front().position_mm == known.camera.fiducials.front().position_mm)
        continue;
      Trial trial = Plain(known);
      trial.read_as = &other;
      Try("read as " + other.camera.name + ", " + std::to_string(other.fiducials.size()) + " marks",
          trial);
      trial.dpi = Vector2d(0, 0);
      Try("the same without a tag", trial);
    }
}

TEST_F(SlowBadReseauScans, NeighbouringFrame) {
  const std::vector<KnownScan> scans = Reseaus(51), others = Reseaus(61);
  for (size_t i = 0; i < scans.size(); ++i) {
    const Image& next = others[i].scan.image;
    Try("half of the next one at the right", WithNeighbour(scans[i], next, false, 0.5));
    Try("a third of the next one below", WithNeighbour(scans[i], next, true, 0.33));
    Try("half of two", HalfAndHalf(scans[i], next));
    Trial both = WithNeighbour(scans[i], next, false, 1);
    both.no_answer = true;
    Try("two whole frames", both);
  }
}

TEST_F(SlowBadReseauScans, OnAScannerBed) {
  for (const KnownScan& known : Reseaus(71)) {
    const int wide = Pixels(known, 0.25 * known.camera.camera.frame_mm.x());
    for (const float bed : {kWhiteBed, kBlackBed})
      Try(bed > 100 ? "white bed" : "black bed",
          With(known, Cut(known.scan, {-wide, -wide / 2, -wide / 3, -2 * wide}, bed)));
  }
}

TEST_F(SlowBadReseauScans, NonsenseResolutionTags) {
  for (const KnownScan& known : Reseaus(81))
    for (const auto& [how, dpi] : NonsenseTags(known)) Try(how, Tagged(known, dpi));
}

TEST_F(SlowBadReseauScans, Turned) {
  for (const KnownScan& known : Reseaus(91))
    for (const double degrees : {2.0, 5.0, 20.0, 45.0})
      Try("turned by " + std::to_string(static_cast<int>(degrees)) + " degrees",
          With(known, TurnedScan(known.scan, degrees, degrees < 8 ? kBlackBed : kWhiteBed)));
}

TEST_F(SlowBadReseauScans, OneBitNoiseAndFog) {
  for (const KnownScan& known : Reseaus(101)) {
    Try("threshold", OneBit(known, 128));
    Try("error diffusion", OneBit(known, std::nullopt));
    Try("noise of 25", With(known, NoisyScan(known.scan, 25, 8)));
    Try("noise of 60", With(known, NoisyScan(known.scan, 60, 9)));
    Try("vignette and fog", With(known, FoggedScan(known.scan, 0.1, 80)));
  }
}

// A camera file with crosses that the film does not have, or a film without a whole side's crosses.
TEST_F(SlowBadReseauScans, RowsOfCrossesMissing) {
  const std::vector<std::pair<std::string, std::vector<int>>> missing = {
      {"a row below", {0, 1, 2, 3, 4}},
      {"a column at the left", {0, 5, 10, 15, 20}},
      {"all but one of a column at the left", {0, 5, 10, 15}},
      {"all but one of the column at the right", {4, 9, 14, 19}},
      {"a row and a column", {0, 1, 2, 3, 4, 5, 10, 15, 20}},
      {"the rows at both sides", {0, 1, 2, 3, 4, 20, 21, 22, 23, 24}}};
  unsigned seed = 111;
  for (const auto& [what, crosses] : missing)
    for (const CameraFile& camera : {Wide(), WithFiducials()})
      Try(what,
          Plain(SimulatedOf(camera.camera.name, camera, kWidePixel_mm, ++seed, true, crosses)));
}

}  // namespace
}  // namespace orient::interior
