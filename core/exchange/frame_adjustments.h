// The files of two classical bundle adjustments of metric photos, PAT-B and BINGO, and the plain
// text of poses that most programs import.
//
// Both know photos by their camera's principal distance alone: image coordinates are relative to
// the principal point, without the lens's distortion, x right and y up. So x = -c d0/d2, y = -c
// d1/d2 with d = R^T (P - P0), R photo to ground.
//
// PAT-B orientation, three records per photo (16 columns per value): number, principal distance
// (mm), X, Y, Z; a11 a12 a13 a21 a22; a23 a31 a32 a33, the rows of R (PCI's "Using Pat-B in
// OrthoEngine" gives the records). Image coordinates in micrometres, photo by photo ended by -99.
// BINGO: image coordinates in mm, the same way, each photo's heading with its camera's name;
// orientations as ORIA lines with angles in gon.
// Plain text: one line a photo, name X Y Z omega phi kappa (degrees), separated by blanks, tabs or
// commas, a name that holds some of these in double quotes; # begins a comment.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"

namespace orient {

struct PatbPhoto {
  std::string number;  // as in the file
  double principal_distance_mm = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  // rows a1. a2. a3.
};

struct BingoPhoto {
  std::string number;
  std::string camera;  // as image.dat beside names it, empty where it does not
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d opk_gon = Eigen::Vector3d::Zero();
};

struct OriPhoto {
  std::string name;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d opk_deg = Eigen::Vector3d::Zero();
};

// A measured point of a photo in its own system, see above; mm.
struct ReducedPoint {
  std::size_t photo = 0;
  std::string point;
  Eigen::Vector2d photo_mm = Eigen::Vector2d::Zero();
};
// All observations of the block, reduced. Throws InputError where a camera has no image size.
std::vector<ReducedPoint> ReducedPoints(const ExchangeBlock& block);
// An ideal pixel of the camera (without distortion) as reduced coordinates, mm, y up.
Eigen::Vector2d ReducedFromPixel(const ExchangeCamera& camera, const Eigen::Vector2d& pixel);

// The number by which the photo is known in both programs: its name where that is one, else its
// place in the block, from 1. WritePatb and WriteBingo list them in photo_numbers.txt.
std::string PhotoNumber(const ExchangeBlock& block, std::size_t photo);

// patb.ori, patb.im (image coordinates), patb.con (control), photo_numbers.txt.
void WritePatb(const std::string& directory, const ExchangeBlock& block);
// itera.dat (ORIA), image.dat, geoin.dat (CONT), photo_numbers.txt.
void WriteBingo(const std::string& directory, const ExchangeBlock& block);

// orientation.ori, with a heading as comment.
void WriteOri(const std::string& directory, const ExchangeBlock& block);

// `path`: the file, or the folder with patb.ori or itera.dat. Photos get their names back where
// photo_numbers.txt lies beside. Throws InputError naming file and line.
std::vector<PatbPhoto> ReadPatb(const std::string& path);
std::vector<BingoPhoto> ReadBingo(const std::string& path);
// `path`: the file, or the folder with orientation.ori. Angles beyond 360 are refused.
std::vector<OriPhoto> ReadOri(const std::string& path);
std::map<std::string, std::string> ReadPhotoNumbers(const std::string& path);

// Poses only: the block's cameras are empty (PAT-B's principal distance and BINGO's name aside) and
// must be given otherwise.
ExchangeBlock ExchangeFromPatb(const std::vector<PatbPhoto>& photos,
                               const std::map<std::string, std::string>& names);
ExchangeBlock ExchangeFromBingo(const std::vector<BingoPhoto>& photos,
                                const std::map<std::string, std::string>& names);
ExchangeBlock ExchangeFromOri(const std::vector<OriPhoto>& photos);

}  // namespace orient
