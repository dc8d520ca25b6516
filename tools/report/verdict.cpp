#include "tools/report/verdict.h"

#include <algorithm>

#include "core/base/chi_square.h"
#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "tools/report/figures/photo_accuracy.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

// A median of fewer says nothing about what is usual.
constexpr size_t kFewestForMedian = 3;

std::optional<double> MedianSigma0(const std::vector<PhotoVerdict>& photos,
                                   std::optional<double> PhotoVerdict::*sigma0) {
  std::vector<double> values;
  for (const PhotoVerdict& photo : photos)
    if (photo.status != Status::kFailed && photo.*sigma0) values.push_back(*(photo.*sigma0));
  if (values.empty()) return std::nullopt;
  return Median(std::move(values));
}

void SummarizeProjections(BlockVerdict* verdict) {
  std::vector<double> px, m;
  for (size_t i = 0; i < verdict->photos.size(); ++i) {
    const PhotoVerdict& photo = verdict->photos[i];
    if (photo.status == Status::kFailed || !photo.projection) continue;
    px.push_back(photo.projection->px);
    m.push_back(photo.projection->m);
    std::optional<size_t>& worst = verdict->worst_projection;
    if (!worst || photo.projection->px > verdict->photos[*worst].projection->px) worst = i;
  }
  if (!px.empty())
    verdict->median_projection = ProjectionSigma{Median(std::move(px)), Median(std::move(m))};
}

// Failed photos sometimes have a pose, but none that is usable.
void JudgeOnGround(const BlockRecord& block, BlockVerdict* verdict) {
  if (!block.camera) return;
  SideBySide(block.photos.size(), [&](std::size_t i) {
    PhotoVerdict& photo = verdict->photos[i];
    if (photo.status != Status::kFailed && block.photos[i].exterior)
      photo.ce90 = AccuracyOnLevelGround(*block.photos[i].exterior, *block.camera);
  });
  std::vector<double> medians_m;
  for (size_t i = 0; i < verdict->photos.size(); ++i) {
    const PhotoVerdict& photo = verdict->photos[i];
    if (!photo.ce90) continue;
    medians_m.push_back(photo.ce90->median_m);
    std::optional<size_t>& worst = verdict->worst_ce90;
    if (!worst || photo.ce90->worst_m > verdict->photos[*worst].ce90->worst_m) worst = i;
  }
  if (!medians_m.empty()) verdict->median_ce90_m = Median(std::move(medians_m));
}

void SummarizeHeights(const std::vector<PointResult>& ties, BlockVerdict* verdict) {
  std::vector<double> sigmas;
  for (const PointResult& tie : ties)
    if (tie.sigma_m) sigmas.push_back(tie.sigma_m->z());
  if (!sigmas.empty()) verdict->median_le90_m = kLinearError90 * Median(std::move(sigmas));
}

double LargestPositionSigma(const PhotoVerdict& photo) {
  return photo.sigma ? photo.sigma->head<3>().maxCoeff() : 0.0;
}

void CountMarks(const InteriorResult& interior, PhotoVerdict* verdict) {
  verdict->marks = static_cast<int>(interior.marks.size());
  verdict->marks_used = static_cast<int>(
      std::count_if(interior.marks.begin(), interior.marks.end(),
                    [](const MarkResult& mark) { return mark.state == MarkState::kUsed; }));
  verdict->sigma0_um = interior.sigma0_um;
}

void CountPatches(const ExteriorResult& exterior, PhotoVerdict* verdict) {
  for (const PatchResult& patch : exterior.patches) {
    verdict->matched += patch.state == PatchState::kMatched;
    verdict->not_found += patch.state == PatchState::kNotFound;
    verdict->rejected += patch.state == PatchState::kRejected;
    verdict->not_visible += patch.state == PatchState::kNotVisible;
  }
  verdict->sigma0_px = exterior.sigma0_px;
  verdict->projection = exterior.projection_sigma;
  verdict->pose = exterior.pose;
  if (exterior.covariance)
    verdict->sigma = exterior.covariance->diagonal().cwiseMax(0.0).cwiseSqrt();
}

void AddReasons(const std::string& stage, const Findings& findings,
                std::vector<std::string>* reasons) {
  for (const std::string& message : Sentences(findings)) reasons->push_back(stage + message);
}

// Status of the last stage; whatever is missing or damaged makes the photo a failed one.
void SetStatus(const PhotoRecord& photo, bool block_has_exterior, PhotoVerdict* verdict) {
  verdict->reasons = photo.unreadable;
  if (photo.interior)
    AddReasons(photo.exterior || block_has_exterior ? "Interior: " : "", photo.interior->findings,
               &verdict->reasons);
  if (photo.exterior) AddReasons("", photo.exterior->findings, &verdict->reasons);
  if (photo.exterior)
    verdict->status = photo.exterior->status;
  else if (photo.interior && !block_has_exterior)
    verdict->status = photo.interior->status;
  else if (photo.interior && photo.interior->status != Status::kFailed)
    verdict->reasons.push_back("it has no exterior orientation; continue with --resume");
  if (!photo.interior && !photo.exterior && photo.table_row) {
    verdict->status = Status::kWeak;
    verdict->reasons.push_back(
        "only orientation.csv has this photo: the quality of its orientation is unknown");
  }
  const bool interior_failed = photo.interior && photo.interior->status == Status::kFailed;
  if (interior_failed && verdict->status != Status::kFailed) {
    verdict->reasons.push_back("its interior orientation failed, so the exterior one is of no use");
    verdict->status = Status::kFailed;
  }
  if (!photo.unreadable.empty()) verdict->status = Status::kFailed;
}

PhotoVerdict JudgePhoto(const PhotoRecord& photo, bool block_has_exterior) {
  PhotoVerdict verdict;
  if (photo.interior) CountMarks(*photo.interior, &verdict);
  if (photo.exterior) CountPatches(*photo.exterior, &verdict);
  if (!photo.exterior && photo.table_row) {
    verdict.pose = photo.table_row->pose;
    verdict.sigma = photo.table_row->sigma;
    verdict.from_table = true;
  }
  SetStatus(photo, block_has_exterior, &verdict);
  return verdict;
}

std::string Times(double value, double usual) {
  return Decimal(value / usual, 1) + " times the block's median";
}

// Number of matched patches with much larger residuals than most of their photo, if there are more
// than photos of houses and trees usually have. Not judged by sigma0, which
// weights residuals by possible height and film errors, which neighbours share.
int OutlyingPatches(const ExteriorResult& exterior) {
  std::vector<double> lengths;
  for (const PatchResult& patch : exterior.patches)
    if (patch.state == PatchState::kMatched && patch.residual_px)
      lengths.push_back(patch.residual_px->norm());
  if (lengths.size() < kFewestForMedian) return 0;
  const double limit = kConspicuousResidual * Median(lengths);
  const auto outlying =
      std::count_if(lengths.begin(), lengths.end(), [&](double length) { return length > limit; });
  const double share = static_cast<double>(outlying) / static_cast<double>(lengths.size());
  return share > kConspicuousShare ? static_cast<int>(outlying) : 0;
}

// What is conspicuous about a photo whose status is ok.
std::vector<std::string> Peculiarities(const PhotoRecord& photo, const PhotoVerdict& verdict,
                                       const BlockVerdict& block, std::optional<double> usual_m) {
  std::vector<std::string> texts;
  const auto outstanding = [](std::optional<double> value, std::optional<double> usual, double k) {
    return value && usual && *usual > 0 && *value > k * *usual;
  };
  if (outstanding(verdict.sigma0_px, block.median_sigma0_px, kConspicuousSigma0))
    texts.push_back("sigma0 of the matches is " + Decimal(*verdict.sigma0_px, 2) + " px, " +
                    Times(*verdict.sigma0_px, *block.median_sigma0_px));
  if (outstanding(verdict.sigma0_um, block.median_sigma0_um, kConspicuousSigma0))
    texts.push_back("sigma0 of the marks is " + Decimal(*verdict.sigma0_um, 1) + " µm, " +
                    Times(*verdict.sigma0_um, *block.median_sigma0_um));
  const double sigma_m = LargestPositionSigma(verdict);
  if (outstanding(sigma_m, usual_m, kConspicuousSigma))
    texts.push_back("position sigma is " + Decimal(sigma_m, 2) + " m, " + Times(sigma_m, *usual_m));
  const int outlying = photo.exterior ? OutlyingPatches(*photo.exterior) : 0;
  if (outlying > 0)
    texts.push_back(
        std::to_string(outlying) +
        (outlying == 1 ? " matched patch has a residual" : " matched patches have residuals") +
        " above " + Decimal(kConspicuousResidual, 0) + " times the photo's median");
  if (photo.interior && photo.exterior && photo.interior->status == Status::kWeak &&
      verdict.status == Status::kOk)
    texts.push_back("the interior orientation is weak: " +
                    Joined(Sentences(photo.interior->findings)));
  return texts;
}

void ListConcerns(const BlockRecord& block, BlockVerdict* verdict) {
  for (const Status status : {Status::kFailed, Status::kWeak})
    for (size_t i = 0; i < block.photos.size(); ++i) {
      if (verdict->photos[i].status != status) continue;
      const std::string reasons = Joined(verdict->photos[i].reasons);
      verdict->concerns.push_back({i, reasons.empty() ? "no reason is given" : reasons});
    }
  std::vector<double> sigmas_m;
  for (const PhotoVerdict& photo : verdict->photos)
    if (photo.status != Status::kFailed && photo.sigma)
      sigmas_m.push_back(LargestPositionSigma(photo));
  BlockVerdict usual = *verdict;  // too few photos have no usual value
  if (sigmas_m.size() < kFewestForMedian) usual.median_sigma0_px.reset();
  if (block.photos.size() < kFewestForMedian) usual.median_sigma0_um.reset();
  std::optional<double> usual_m;
  if (sigmas_m.size() >= kFewestForMedian) usual_m = Median(std::move(sigmas_m));
  for (size_t i = 0; i < block.photos.size(); ++i) {
    if (verdict->photos[i].status != Status::kOk) continue;
    const auto texts = Peculiarities(block.photos[i], verdict->photos[i], usual, usual_m);
    if (!texts.empty()) verdict->concerns.push_back({i, Joined(texts)});
  }
}

}  // namespace

BlockVerdict Judge(const BlockRecord& block) {
  BlockVerdict verdict;
  const bool has_exterior = block.HasExterior();
  for (const PhotoRecord& photo : block.photos) {
    verdict.photos.push_back(JudgePhoto(photo, has_exterior));
    const PhotoVerdict& judged = verdict.photos.back();
    verdict.ok += judged.status == Status::kOk;
    verdict.weak += judged.status == Status::kWeak;
    verdict.failed += judged.status == Status::kFailed;
    verdict.matched += judged.matched;
    verdict.searched += judged.Searched();
  }
  verdict.median_sigma0_px = MedianSigma0(verdict.photos, &PhotoVerdict::sigma0_px);
  SummarizeProjections(&verdict);
  JudgeOnGround(block, &verdict);
  if (block.adjusted) SummarizeHeights(block.adjusted->ties, &verdict);
  verdict.median_sigma0_um = MedianSigma0(verdict.photos, &PhotoVerdict::sigma0_um);
  for (size_t i = 0; i < verdict.photos.size(); ++i) {
    const PhotoVerdict& photo = verdict.photos[i];
    if (!photo.sigma || photo.status == Status::kFailed) continue;
    if (!verdict.least_precise ||
        LargestPositionSigma(photo) > LargestPositionSigma(verdict.photos[*verdict.least_precise]))
      verdict.least_precise = i;
  }
  ListConcerns(block, &verdict);
  return verdict;
}

}  // namespace orient
