// Identification symbols: rows of lines or dots that number the marks (Wild RC20 and RC30: lines
// beside marks 1 to 4, dots beside 5 to 8; Kersten & Haering 1997, figure 4).
#pragma once

#include <optional>

#include "core/files/camera_file.h"
#include "interior/marks/film_tone.h"

namespace orient::interior {

// What is around a mark, in tones; the origin is the mark's centre, the axes are parallel to those
// of the photo as the film is assumed to lie.
struct MarkSurroundings {
  TonePicture picture;
  double mark_radius_mm = 0;
};

// Reaches far enough for every symbol the camera file allows.
MarkSurroundings SurroundingsOf(const Raster& scan, const MarkShape& shape,
                                const Eigen::Matrix2d& pixel_from_mm, const Eigen::Vector2d& pixel,
                                const FilmTone& tone);

// Does a symbol whose places are known (`at_mm`, and `step_mm` for more than one element) stand
// there, were the mark's photo axes turned by `turn` (orthogonal: surroundings from photo)? The
// log-likelihood ratio against any other thing standing there, nats, within +-3: each element must
// stand out from the gaps beside it, the place after the last one must be empty, and elements must
// be as long as bars or as round as dots. 0 where brightness beside the elements hides the answer.
double NatsOfSymbol(const MarkSurroundings& around, const MarkSymbol& symbol,
                    const Eigen::Matrix2d& turn);
inline constexpr double kMostSymbolNats = 3.0;

// A row of equal elements with equal steps, found anywhere around the mark.
struct SymbolRow {
  SymbolKind kind = SymbolKind::kLines;
  int count = 0;
  Eigen::Vector2d first_mm = Eigen::Vector2d::Zero();  // its two ends
  Eigen::Vector2d last_mm = Eigen::Vector2d::Zero();
};

// The only row there is within 6 mm of the mark; empty where there is none, or more than one.
std::optional<SymbolRow> FindSymbolRow(const MarkSurroundings& around);

}  // namespace orient::interior
