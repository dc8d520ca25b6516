#include "interior/orientation/film_orientation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "interior/marks/symbols.h"
#include "interior/orientation/film_border.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kDissentNats = 3.0;
constexpr double kClearNats = 2.0;
// Votes needed to outvote a clear one to the contrary. Of eight clean symbols one is misread on one
// photo in 24.
constexpr size_t kOutvoting = 7;
constexpr double kReadNats = 1.5;  // what a symbol must reach in some scan orientation to be read
constexpr double kRowNats = 2.0;   // a row of unknown place that has, or has not, the right count
constexpr double kSamePlaceMm = 1.0;

double Best(const OrientationVote& vote) {
  return *std::max_element(vote.nats.begin(), vote.nats.end());
}

bool IsSilent(const OrientationVote& vote) {
  return !vote.fits_none &&
         std::all_of(vote.nats.begin(), vote.nats.end(), [](double nats) { return nats == 0; });
}

bool Dissents(const OrientationVote& vote, size_t from) {
  return vote.fits_none || vote.nats[from] < Best(vote) - kDissentNats;
}

bool ClearlyDissents(const OrientationVote& vote, size_t from) {
  return vote.fits_none || (Best(vote) >= kClearNats && vote.nats[from] <= -kClearNats);
}

// The symbol that a mark would have beside it if the film lay in one of the open scan orientations.
struct Hypothesis {
  const MarkSymbol* symbol = nullptr;  // none: the mark it would be has no symbol
  Matrix2d turn =
      Matrix2d::Identity();  // to the photo axes assumed when measuring, from this orientation's
};

bool HasPlace(const MarkSymbol& symbol) { return symbol.at_mm && symbol.step_mm; }

std::vector<double> NatsOfPlaces(const MarkSurroundings& around,
                                 const std::vector<Hypothesis>& hypotheses) {
  std::vector<double> vote;
  double read = 0;
  for (const Hypothesis& h : hypotheses) {
    vote.push_back(h.symbol != nullptr ? NatsOfSymbol(around, *h.symbol, h.turn) : 0);
    read = std::max(read, vote.back());
  }
  if (read < kReadNats) return std::vector<double>(hypotheses.size(), 0);
  for (size_t o = 0; o < hypotheses.size(); ++o)
    if (hypotheses[o].symbol == nullptr) vote[o] = -read;  // what was read would not be explained
  return vote;
}

// Whether the row is of the hypothesis' kind, and in its place if that is known.
bool MayBe(const SymbolRow& row, const Hypothesis& hypothesis) {
  constexpr double kNearMm = 0.6;
  if (hypothesis.symbol == nullptr || row.kind != hypothesis.symbol->kind) return false;
  if (!hypothesis.symbol->at_mm) return true;
  const Vector2d at = hypothesis.turn * *hypothesis.symbol->at_mm;
  return std::min((row.first_mm - at).norm(), (row.last_mm - at).norm()) < kNearMm;
}

OrientationVote VoteOfRow(const MarkSurroundings& around,
                          const std::vector<Hypothesis>& hypotheses) {
  OrientationVote vote{std::vector<double>(hypotheses.size(), 0)};
  const auto row = FindSymbolRow(around);
  if (!row) return vote;
  const auto fits = [&](const Hypothesis& h) {
    return MayBe(*row, h) && row->count == h.symbol->count;
  };
  if (std::none_of(hypotheses.begin(), hypotheses.end(), fits)) {
    // A row of another kind, or a single patch, is something else; one of the symbol's kind with a
    // count that no scan orientation has is the symbol of another mark or another camera.
    vote.fits_none =
        row->count > 1 && std::any_of(hypotheses.begin(), hypotheses.end(),
                                      [&](const Hypothesis& h) { return MayBe(*row, h); });
    return vote;
  }
  for (size_t o = 0; o < hypotheses.size(); ++o)
    vote.nats[o] = fits(hypotheses[o]) ? kRowNats : -kRowNats;
  return vote;
}

OrientationVote VoteOfSymbol(const MarkSurroundings& around,
                             const std::vector<Hypothesis>& hypotheses) {
  const bool places_known =
      std::all_of(hypotheses.begin(), hypotheses.end(),
                  [](const Hypothesis& h) { return h.symbol == nullptr || HasPlace(*h.symbol); });
  return places_known ? OrientationVote{NatsOfPlaces(around, hypotheses)}
                      : VoteOfRow(around, hypotheses);
}

// Votes of the film on its scan orientation, once its marks are measured.
class FilmVotes {
 public:
  FilmVotes(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
            const InteriorResult& measured, const OrientationClass& open)
      : scan_(scan),
        camera_(camera),
        shapes_(shapes),
        measured_(measured),
        open_(open),
        pixel_from_photo_(measured.photo_from_pixel.value().Inverse()) {
    for (const ScanOrientation o : open) {
      relabels_.push_back(Relabel(camera.fiducials, shapes, open.front(), o).value());
      turns_.push_back(PhotoTurn(o, open.front()));
    }
    for (size_t i = 0; i < measured.marks.size(); ++i)
      if (measured.marks[i].state == MarkState::kUsed)
        tones_.push_back(ToneAtMark(scan, shapes.at(camera.fiducials[i].mark), pixel_from_photo_.A,
                                    measured.marks[i].pixel.value(), measured.polarity.value()));
      else
        tones_.emplace_back();
  }

  std::vector<OrientationVote> OfSymbols() const {
    std::vector<OrientationVote> votes;
    for (size_t i = 0; i < tones_.size(); ++i) {
      const auto hypotheses = HypothesesOf(i);
      const bool any = std::any_of(hypotheses.begin(), hypotheses.end(),
                                   [](const Hypothesis& h) { return h.symbol != nullptr; });
      if (!any || !tones_[i]) continue;
      votes.push_back(VoteOfSymbol(
          SurroundingsOf(scan_, shapes_.at(camera_.fiducials[i].mark), pixel_from_photo_.A,
                         measured_.marks[i].pixel.value(), *tones_[i]),
          hypotheses));
      votes.back().mark = i;
    }
    return votes;
  }

  std::vector<OrientationVote> OfBorder() const {
    std::vector<OrientationVote> votes;
    const auto tone = MiddleTone();
    if (!tone) return votes;
    for (const BorderFeature& feature : BorderFeatures(camera_)) {
      const size_t index = votes.size();
      votes.push_back(OfFeature(feature, *tone));
      votes.back().feature = index;
    }
    return votes;
  }

 private:
  std::vector<Hypothesis> HypothesesOf(size_t mark) const {
    std::vector<Hypothesis> hypotheses;
    for (size_t o = 0; o < open_.size(); ++o) {
      const auto& symbol = camera_.fiducials[relabels_[o][mark]].symbol;
      hypotheses.push_back({symbol ? &*symbol : nullptr, turns_[o]});
    }
    return hypotheses;
  }

  OrientationVote OfFeature(const BorderFeature& feature, const FilmTone& tone) const {
    std::vector<BorderPlace> places;
    std::vector<size_t> place_of;
    for (const Matrix2d& turn : turns_) {
      const BorderPlace place = Turned(feature, turn);
      const auto same = std::find_if(places.begin(), places.end(), [&](const BorderPlace& p) {
        return (p.low_mm - place.low_mm).norm() < kSamePlaceMm &&
               (p.high_mm - place.high_mm).norm() < kSamePlaceMm;
      });
      place_of.push_back(static_cast<size_t>(same - places.begin()));
      if (same == places.end()) places.push_back(place);
    }
    std::vector<Vector2d> marks;
    for (const Fiducial& f : camera_.fiducials) marks.push_back(f.position_mm);
    std::vector<SignSeen> seen;
    for (const BorderPlace& place : places)
      seen.push_back(LookFor(feature.shows, place, scan_, pixel_from_photo_, tone, marks));
    OrientationVote vote{NatsOfFeature(feature.shows, seen, place_of)};
    vote.off_scan = IsSilent(vote) && std::none_of(places.begin(), places.end(),
                                                   [&](const auto& p) { return IsOnScan(p); });
    return vote;
  }

  // Whether at least half of the place is on the scan.
  bool IsOnScan(const BorderPlace& place) const {
    constexpr int kSamples = 10;  // per axis
    int inside = 0;
    for (int j = 0; j < kSamples; ++j)
      for (int i = 0; i < kSamples; ++i) {
        const Vector2d share = Vector2d(i + 0.5, j + 0.5) / kSamples;
        const Vector2d at =
            pixel_from_photo_ *
            Vector2d(place.low_mm + share.cwiseProduct(place.high_mm - place.low_mm));
        if (at.minCoeff() >= 0 && at.x() < scan_.Width() && at.y() < scan_.Height()) ++inside;
      }
    return 2 * inside >= kSamples * kSamples;
  }

  // Where the feature lies in the photo axes assumed when measuring; the marks' rectangle keeps its
  // place whichever way the film lies.
  BorderPlace Turned(const BorderFeature& feature, const Matrix2d& turn) const {
    const Vector2d centre = RectangleOfMarks(camera_.fiducials).centre_mm;
    const Vector2d a = turn * (feature.from_mm - centre) + centre;
    const Vector2d b = turn * (feature.to_mm - centre) + centre;
    return {a.cwiseMin(b), a.cwiseMax(b)};
  }

  // The tone at the mark of median contrast, which represents the film.
  std::optional<FilmTone> MiddleTone() const {
    std::vector<FilmTone> read;
    for (const auto& tone : tones_)
      if (tone) read.push_back(*tone);
    if (read.empty()) return std::nullopt;
    std::sort(read.begin(), read.end(), [](const FilmTone& a, const FilmTone& b) {
      return std::abs(a.stroke - a.surrounding) < std::abs(b.stroke - b.surrounding);
    });
    return read[read.size() / 2];
  }

  const Raster& scan_;
  const CameraFile& camera_;
  const MarkShapes& shapes_;
  const InteriorResult& measured_;
  const OrientationClass& open_;
  Affine2d pixel_from_photo_;
  std::vector<std::vector<int>> relabels_;      // per scan orientation
  std::vector<Matrix2d> turns_;                 // per scan orientation
  std::vector<std::optional<FilmTone>> tones_;  // per mark
};

}  // namespace

OrientationDecision Decide(const OrientationClass& open,
                           const std::vector<OrientationVote>& votes) {
  std::vector<double> total(open.size(), 0);
  for (const OrientationVote& vote : votes)
    for (size_t o = 0; o < open.size(); ++o) total[o] += vote.nats[o];
  std::vector<size_t> order(open.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return total[a] > total[b]; });
  const size_t best = order.front();
  const auto read = static_cast<size_t>(
      std::count_if(votes.begin(), votes.end(), [](const auto& vote) { return !IsSilent(vote); }));
  OrientationDecision decision;
  size_t clearly = 0;
  for (size_t i = 0; i < votes.size(); ++i) {
    if (IsSilent(votes[i]) || !Dissents(votes[i], best)) continue;
    decision.dissenting.push_back(i);
    if (ClearlyDissents(votes[i], best)) ++clearly;
  }
  decision.contradictory = clearly * kOutvoting > read - clearly ||
                           (!decision.dissenting.empty() && 4 * decision.dissenting.size() >= read);
  if (decision.contradictory) {
    decision.possible = open;
    for (const double nats : total) decision.nats.push_back(nats - total[best]);
    return decision;
  }
  for (const size_t o : order) {
    if (total[o] <= total[best] - kSureNats) continue;
    decision.possible.push_back(open[o]);
    decision.nats.push_back(total[o] - total[best]);
  }
  return decision;
}

void AddRivals(const std::vector<RivalOrientation>& rivals, OrientationDecision* decision) {
  std::vector<double>& nats = decision->nats;
  for (const RivalOrientation& rival : rivals) {
    if (rival.nats >= kSureNats) continue;
    // Contradictory votes give no order.
    const auto place = decision->contradictory
                           ? nats.end()
                           : std::find_if(nats.begin(), nats.end(),
                                          [&](double other) { return other < -rival.nats; });
    decision->possible.insert(decision->possible.begin() + (place - nats.begin()),
                              rival.orientation);
    nats.insert(place, -rival.nats);
  }
}

std::vector<OrientationVote> VotesOfFilm(const Raster& scan, const CameraFile& camera,
                                         const MarkShapes& shapes, const InteriorResult& measured,
                                         const OrientationClass& open) {
  const bool has_symbols = std::any_of(camera.fiducials.begin(), camera.fiducials.end(),
                                       [](const Fiducial& f) { return f.symbol.has_value(); });
  const bool has_border = camera.data_strip || !camera.border.empty();
  if (open.size() < 2 || !(has_symbols || has_border)) return {};
  const FilmVotes film(scan, camera, shapes, measured, open);
  std::vector<OrientationVote> votes = film.OfSymbols();
  const std::vector<OrientationVote> border = film.OfBorder();
  votes.insert(votes.end(), border.begin(), border.end());
  return votes;
}

}  // namespace orient::interior
