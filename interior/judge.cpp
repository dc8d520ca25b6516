#include "interior/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "interior/constellation/clicked_film.h"
#include "interior/constellation/set_evidence.h"
#include "interior/orientation/film_orientation.h"

namespace orient::interior {
namespace {

constexpr double kMaxScaleDifference = 0.03;
constexpr double kMaxShear = 0.015;
// Resolution tags and users' values are right within 1 %, film and prints are as stable in size;
// similar marks of another camera lie 2 % farther out or in.
constexpr double kMaxOffStatedSize = 0.015;
constexpr double kStatedSigma = 0.01;             // a larger one: the pixel size was not stated
constexpr double kMaxSigma0Photogrammetric = 60;  // um
constexpr double kMaxSigma0Desktop = 350;         // um
constexpr double kNotableSigma0 = 30;             // um: reported, though accepted

Findings JudgeFilm(const FilmReading& reading, const FilmTransform& film) {
  Findings findings;
  const auto weak = [&](Reason reason, double value, std::optional<double> limit = {}) {
    findings.push_back({reason, Status::kWeak, value, limit});
  };
  if (std::abs(film.shape.scale_difference) > kMaxScaleDifference)
    weak(Reason::kScaleDifference, 100 * film.shape.scale_difference, 100 * kMaxScaleDifference);
  if (std::abs(film.shape.shear_rad) > kMaxShear)
    weak(Reason::kShear, 1e3 * film.shape.shear_rad, 1e3 * kMaxShear);
  const double stated_um = 1e3 * reading.pixel_size.pixel_mm;
  if (reading.pixel_size.sigma < kStatedSigma &&
      std::abs(film.pixel_um / stated_um - 1) > kMaxOffStatedSize)
    weak(Reason::kPixelSizeIsNotAsStated, film.pixel_um, stated_um);
  if (reading.scanner_margin <= kMinMarginNats)
    weak(Reason::kRivalScanner, reading.scanner_margin, kMinMarginNats);
  const double orientation_margin = OrientationMargin(reading);
  if (orientation_margin < kSureNats)
    weak(Reason::kRivalScanOrientation, orientation_margin, kSureNats);
  const double limit =
      reading.scanner == Scanner::kPhotogrammetric ? kMaxSigma0Photogrammetric : kMaxSigma0Desktop;
  if (film.sigma0_um > limit)
    weak(Reason::kLargeSigma0, film.sigma0_um, limit);
  else if (film.affine && film.sigma0_um > kNotableSigma0)
    findings.push_back({Reason::kFilmDistorted, Status::kOk, film.sigma0_um, kNotableSigma0});
  return findings;
}

// With a wrongly stated polarity no marks are found, or clutter of that polarity that fits.
std::optional<Finding> PolarityContradicted(const FilmReading& reading) {
  if (reading.polarity_margin > -kSureNats) return std::nullopt;
  return Finding{Reason::kPolarityUnlikeMarks, Status::kWeak, -reading.polarity_margin, kSureNats,
                 std::string(Name(Opposite(reading.polarity)))};
}

// Empty if nothing contradicts the set of marks. `nats`: NatsOfUsed.
std::optional<Finding> WhyNotThere(const FilmReading& reading, int used, double nats,
                                   const std::string& unused) {
  const auto failed = [](Reason reason, double value, double limit, const std::string& where = {}) {
    return Finding{reason, Status::kFailed, value, limit, where};
  };
  const int matched = reading.best.Matched();
  if (matched < 3) return failed(Reason::kMarksNotFound, matched, 3);
  if (used < 3) return failed(Reason::kFewMarks, used, 3, unused);
  const double needed = MinSetNats(static_cast<int>(reading.marks.size()));
  if (nats < needed) return failed(Reason::kMarksMayBeChance, nats, needed, unused);
  if (!reading.proven) return Finding{Reason::kTooManyReadings, Status::kFailed};
  if (reading.margin <= kMinMarginNats)
    return failed(Reason::kRivalReading, reading.margin, kMinMarginNats, unused);
  return std::nullopt;
}

// A few of them by name.
std::string SomeOf(const std::vector<std::string>& ids) {
  constexpr size_t kMost = 8;
  const auto some = std::min(ids.size(), kMost);
  std::string list = fmt::format("{}", fmt::join(ids.begin(), ids.begin() + some, ", "));
  if (ids.size() > some) list += fmt::format(" and {} more", ids.size() - some);
  return list;
}

std::string NamesOf(const std::vector<ScanOrientation>& orientations) {
  std::vector<std::string_view> names;
  for (const ScanOrientation orientation : orientations) names.push_back(Name(orientation));
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

double NatsOfUsed(const FilmReading& reading, const FilmMarks& marks) {
  std::vector<int> used(marks.size(), -1);
  for (size_t i = 0; i < marks.size(); ++i)
    if (marks[i].state == MarkState::kUsed) used[i] = reading.best.choice[i];
  return std::min(reading.best.nats, NatsOfSet(reading.marks, reading.prior, used));
}

Findings Judge(const FilmReading& reading, const FilmMarks& marks,
               const std::optional<FilmTransform>& film, const std::vector<std::string>& unused) {
  const int all = static_cast<int>(marks.size());
  const int used = Count(marks, MarkState::kUsed);
  const double nats = NatsOfUsed(reading, marks);
  Findings findings;
  if (const auto other = PolarityContradicted(reading)) findings.push_back(*other);
  if (const auto why = WhyNotThere(reading, used, nats, SomeOf(unused))) {
    for (Finding& cause : findings) cause.at_best = Status::kFailed;
    findings.push_back(*why);
    return findings;
  }
  if (!film) {
    findings.push_back({Reason::kMarksOnOneLine, Status::kFailed});
    return findings;
  }
  if (JudgeSet(all, used, nats, reading.margin) == Status::kWeak)
    findings.push_back({Reason::kFewMarks, Status::kWeak, used, NeededMarks(all), SomeOf(unused)});
  const Findings of_film = JudgeFilm(reading, *film);
  findings.insert(findings.end(), of_film.begin(), of_film.end());
  return findings;
}

std::optional<Finding> JudgeRejected(const std::vector<std::string>& perhaps_wrong) {
  if (perhaps_wrong.empty()) return std::nullopt;
  return Finding{.reason = Reason::kWrongMarkUnclear,
                 .at_best = Status::kWeak,
                 .where = fmt::format("{}", fmt::join(perhaps_wrong, ", "))};
}

Finding PixelSizeIsUnsure(const InteriorResult& result) {
  return {Reason::kPixelSizeUnsure, Status::kWeak, result.pixel_size_um.value_or(0)};
}

std::optional<Finding> JudgePixelSize(const FilmReading& reading, const InteriorResult& result) {
  if (!result.pixel_size_um || reading.pixel_size.sigma < kStatedSigma) return std::nullopt;
  return PixelSizeIsUnsure(result);
}

std::optional<Finding> JudgeReseau(const InteriorResult& result) {
  const auto used = std::count_if(result.marks.begin(), result.marks.end(),
                                  [](const auto& m) { return m.state == MarkState::kUsed; });
  if (!result.reseau) {
    if (used < kLeastReseauMarks) return std::nullopt;
    return Finding{Reason::kReseauContradictory, Status::kWeak};
  }
  const int needed = NeededMarks(static_cast<int>(result.marks.size()));
  const std::string figures = fmt::format("noise {:.1f} um, left-out crosses {:.1f} um",
                                          result.reseau->noise_um, result.reseau->left_out_rms_um);
  const int crosses = result.reseau->crosses;
  if (crosses >= needed)
    return Finding{Reason::kReseauCorrection, Status::kOk, crosses, needed, figures};
  return Finding{Reason::kFewReseauCrosses, Status::kWeak, crosses, needed, figures};
}

std::optional<Finding> JudgeImageSize(const Eigen::Vector2i& image_px,
                                      const Eigen::Vector2i& camera_px) {
  if (image_px == camera_px) return std::nullopt;
  return Finding{.reason = Reason::kImageSizeIsNotTheCameras,
                 .at_best = Status::kFailed,
                 .where = fmt::format("{} x {} pixels, the camera's image_px is {} x {}",
                                      image_px.x(), image_px.y(), camera_px.x(), camera_px.y())};
}

Finding BlackAndWhite() { return {Reason::kBlackAndWhite, Status::kWeak}; }

std::optional<Finding> JudgeGivenByLayout(ScanOrientation given, ScanOrientation best,
                                          double nats) {
  if (nats < kSureNats) return std::nullopt;
  return Finding{Reason::kOrientationUnlikeLayout, Status::kWeak, nats, kSureNats,
                 fmt::format("{}, not {}", Name(best), Name(given))};
}

std::optional<Finding> JudgeGivenBySigns(ScanOrientation given,
                                         const std::vector<ScanOrientation>& possible) {
  if (std::find(possible.begin(), possible.end(), given) != possible.end()) return std::nullopt;
  return Finding{.reason = Reason::kOrientationUnlikeSigns,
                 .at_best = Status::kWeak,
                 .where = fmt::format("{}, not {}", NamesOf(possible), Name(given))};
}

Findings JudgeFound(bool contradictory, const std::string& dissenting,
                    const std::vector<ScanOrientation>& possible) {
  Findings findings;
  if (contradictory)
    findings.push_back({.reason = Reason::kSignsContradictory, .where = dissenting});
  else if (!dissenting.empty())
    findings.push_back({.reason = Reason::kSignNotClear, .where = dissenting});
  if (possible.size() > 1)
    findings.push_back({.reason = Reason::kOrientationOpen, .where = NamesOf(possible)});
  return findings;
}

std::optional<Finding> JudgeOffScan(const std::string& features,
                                    const std::vector<ScanOrientation>& possible) {
  if (features.empty() || possible.size() < 2) return std::nullopt;
  return Finding{.reason = Reason::kBorderOffScan, .where = features};
}

Findings JudgeClicks(const std::vector<MarkClick>& clicks, const InteriorResult& result) {
  std::vector<std::string> off, unseen, contradicted;
  int exact = 0, used = 0;
  for (const MarkResult& mark : result.marks) {
    const bool is_used = mark.state == MarkState::kUsed;
    if (is_used) ++used;
    const MarkClick* click = ClickOn(clicks, mark.id);
    if (!click) continue;
    if (click->exact && is_used) ++exact;
    const double off_px = mark.pixel ? (*mark.pixel - click->pixel).norm() : 0;
    if (is_used && off_px > ClickReach_px(*click))
      off.push_back(fmt::format("{} ({:.0f} px)", mark.id, off_px));
    else if (!is_used)
      (mark.state == MarkState::kRejected ? contradicted : unseen).push_back(mark.id);
  }
  Findings findings;
  const auto tell = [&](Reason reason, const std::vector<std::string>& marks) {
    if (!marks.empty())
      findings.push_back({.reason = reason,
                          .value = static_cast<double>(marks.size()),
                          .where = fmt::format("{}", fmt::join(marks, ", "))});
  };
  tell(Reason::kClickOffMark, off);
  tell(Reason::kClickContradicted, contradicted);
  tell(Reason::kClickNotSeen, unseen);
  const int needed = NeededMarks(static_cast<int>(result.marks.size()));
  if (exact > 0)
    findings.push_back(
        {Reason::kExactClicks, used - exact < needed ? Status::kWeak : Status::kOk, exact, needed});
  return findings;
}

Finding AllClicksContradicted(const std::vector<MarkClick>& clicks) {
  std::vector<std::string> marks;
  for (const MarkClick& click : clicks) marks.push_back(click.mark);
  return {.reason = Reason::kClickContradicted,
          .value = static_cast<double>(marks.size()),
          .where = fmt::format("{}", fmt::join(marks, ", "))};
}

void Add(const Findings& findings, InteriorResult* result) {
  result->findings.insert(result->findings.end(), findings.begin(), findings.end());
  result->status = std::max(result->status, StatusOf(findings));
}

void Add(const std::optional<Finding>& finding, InteriorResult* result) {
  if (finding) Add(Findings{*finding}, result);
}

}  // namespace orient::interior
