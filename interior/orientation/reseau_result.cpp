#include "interior/orientation/reseau_result.h"

#include <algorithm>
#include <vector>

#include "interior/orientation/film_transform.h"
#include "interior/orientation/reseau.h"

namespace orient::interior {

bool FitUsedMarks(const CameraFile& camera, bool mirrored, InteriorResult* result) {
  std::vector<MeasuredMark> used;
  for (size_t i = 0; i < result->marks.size(); ++i)
    if (result->marks[i].state == MarkState::kUsed)
      used.push_back({result->marks[i].pixel.value(), camera.fiducials[i].position_mm});
  const auto film = FitFilm(used, mirrored);
  if (!film) return false;
  result->photo_from_pixel = film->photo_from_pixel;
  result->pixel_size_um = film->pixel_um;
  if (film->affine) result->sigma0_um = film->sigma0_um;
  for (size_t i = 0; i < result->marks.size(); ++i) {
    MarkResult& mark = result->marks[i];
    if (mark.state == MarkState::kUsed || (mark.residual_um && mark.pixel))
      mark.residual_um =
          1e3 * (camera.fiducials[i].position_mm - film->photo_from_pixel * *mark.pixel);
  }
  return true;
}

void CorrectFilm(const CameraFile& camera, bool mirrored, InteriorResult* result) {
  result->reseau.reset();
  if (!result->photo_from_pixel) return;
  constexpr int kMostRounds = 3;  // the second one mostly finds nothing more
  const InteriorResult uncorrected = *result;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<MeasuredMark> used;
    std::vector<size_t> index;
    for (size_t i = 0; i < result->marks.size(); ++i) {
      if (result->marks[i].state != MarkState::kUsed) continue;
      used.push_back({result->marks[i].pixel.value(), camera.fiducials[i].position_mm});
      index.push_back(i);
    }
    const auto fit = FitReseau(used, *result->photo_from_pixel);
    if (!fit) break;
    const auto crosses = static_cast<int>(std::count(fit->used.begin(), fit->used.end(), true));
    result->reseau = ReseauResult{fit->correction, crosses, fit->noise_um, fit->left_out_rms_um};
    if (crosses == std::ssize(used)) return;
    for (size_t k = 0; k < index.size(); ++k)
      if (!fit->used[k]) result->marks[index[k]].state = MarkState::kRejected;
    if (!FitUsedMarks(camera, mirrored, result)) break;
  }
  // Contradictory in every round: then it cannot be decided which crosses are wrong.
  *result = uncorrected;
}

}  // namespace orient::interior
