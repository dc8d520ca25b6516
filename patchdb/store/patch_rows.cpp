#include "patchdb/store/patch_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "patchdb/store/geopackage_geometry.h"
#include "patchdb/store/patch_blobs.h"
#include "patchdb/store/patch_limits.h"
#include "patchdb/store/row_values.h"

namespace orient::patchdb {
namespace {

// Heights need not be stored more finely than they are known, nor than they can be seen: rounding
// to half their sigma makes that 1 % larger. Rounding errors of nodes are independent, so that they
// hardly affect a chip's position.
double HeightQuantum(const Patch& patch) {
  const double finest_m = patch.gsd_m / 64, coarsest_m = patch.gsd_m / 4;
  if (!patch.height_sigma_m || !std::isfinite(*patch.height_sigma_m)) return finest_m;
  return std::clamp(*patch.height_sigma_m / 2, finest_m, coarsest_m);
}

void BindBlob(SQLite::Statement& statement, int index, const Bytes& bytes) {
  statement.bind(index, static_cast<const void*>(bytes.data()), static_cast<int>(bytes.size()));
}

template <typename T>
void BindOptional(SQLite::Statement& statement, int index, const std::optional<T>& value) {
  if (value)
    statement.bind(index, *value);
  else
    statement.bind(index);
}

void BindPixel(SQLite::Statement& statement, int index,
               const std::optional<Eigen::Vector2d>& pixel) {
  if (!pixel) return;
  statement.bind(index, pixel->x());
  statement.bind(index + 1, pixel->y());
}

std::optional<Eigen::Vector2d> PixelOf(const SQLite::Statement& row, int index) {
  if (row.getColumn(index).isNull() || row.getColumn(index + 1).isNull()) return std::nullopt;
  return Eigen::Vector2d(row.getColumn(index).getDouble(), row.getColumn(index + 1).getDouble());
}

// Columns of the SELECT in patchdb/store/statements.h; those up to kChip are also the parameters of
// its INSERT and UPDATE, counted from 1 there.
enum PatchColumn {
  kGeom,
  kGsd,
  kBits,
  kBands,
  kCovariance,
  kHeightEffect,
  kHeightSigma,
  kRoundness,
  kDistinctness,
  kSecondPeak,
  kPersistence,
  kRelief,
  kLean,
  kEnergyXx,
  kEnergyXy,
  kEnergyYy,
  kQuality,
  kHeightsSize,
  kHeightsStep,
  kHeightsBase,
  kHeightsQuantum,
  kHeights,
  kChipMask,
  kChip,
  kId,
  kSourceId,
  kState,
  kRetiredReason,
  kSupersededBy,
  kEpoch,
  kCreated,
  kViews,
  kSuccessWeight,
  kFailureWeight,
  kRetiredOn
};
static_assert(kChip + 1 == kPatchValues);

void BindHeights(const Patch& patch, SQLite::Statement& statement) {
  if (patch.heights.size == 0) return;
  statement.bind(kHeightsSize + 1, patch.heights.size);
  statement.bind(kHeightsStep + 1, patch.heights.step_m);
  const auto packed = PackHeights(patch.heights, HeightQuantum(patch));
  if (!packed) return BindBlob(statement, kHeights + 1, EncodeHeights(patch.heights));
  statement.bind(kHeightsBase + 1, packed->base_m);
  statement.bind(kHeightsQuantum + 1, packed->quantum_m);
  BindBlob(statement, kHeights + 1, packed->png);
}

// What a pixel or a cell may measure on the ground.
constexpr double kLeastLength_m = 1e-5, kGreatestLength_m = 1e5;
// Horizontal displacement by an error of height: the tangent of how obliquely the patch was seen.
constexpr double kGreatestEffect = 10;

bool IsBetween(double value, double least, double greatest) {
  return value >= least && value <= greatest;  // no NaN
}

StoredHeights HeightsOf(const SQLite::Statement& row) {
  if (row.getColumn(kHeights).isNull()) return {};
  StoredHeights heights{BytesOf(row.getColumn(kHeights)), row.getColumn(kHeightsSize).getInt(),
                        RequiredNumberOf(row.getColumn(kHeightsStep)),
                        CheckedNumberOf(row.getColumn(kHeightsBase)),
                        CheckedNumberOf(row.getColumn(kHeightsQuantum))};
  if (!IsBetween(heights.step_m, kLeastLength_m, kGreatestLength_m))
    throw InputError(fmt::format("its heights_step_m is {}", heights.step_m));
  if (heights.quantum_m && !(*heights.quantum_m > 0 && *heights.quantum_m <= kGreatestLength_m))
    throw InputError(fmt::format("its heights_quantum_m is {}", *heights.quantum_m));
  return heights;
}

HeightGrid Unpacked(const StoredHeights& heights) {
  if (!heights.bytes) return {};
  if (heights.base_m && heights.quantum_m)
    return UnpackHeights({*heights.bytes, *heights.base_m, *heights.quantum_m}, heights.size,
                         heights.step_m);
  return DecodeHeights(*heights.bytes, heights.size, heights.step_m);
}

void ReadQualities(const SQLite::Statement& row, Patch& patch) {
  patch.roundness = CheckedNumberOf(row.getColumn(kRoundness));
  patch.distinctness = CheckedNumberOf(row.getColumn(kDistinctness));
  patch.second_peak_px = CheckedNumberOf(row.getColumn(kSecondPeak));
  patch.persistence = CheckedNumberOf(row.getColumn(kPersistence));
  patch.relief_px = CheckedNumberOf(row.getColumn(kRelief));
  patch.lean_px = CheckedNumberOf(row.getColumn(kLean));
  if (!row.getColumn(kEnergyXx).isNull())
    patch.energy = {RequiredNumberOf(row.getColumn(kEnergyXx)),
                    RequiredNumberOf(row.getColumn(kEnergyXy)),
                    RequiredNumberOf(row.getColumn(kEnergyYy))};
  patch.quality = CheckedNumberOf(row.getColumn(kQuality));
}

void ReadLife(const SQLite::Statement& row, Patch& patch) {
  const std::string state = row.getColumn(kState).getString();
  if (state != "active" && state != "retired")
    throw InputError("its state is '" + state + "'; it must be 'active' or 'retired'");
  patch.life = state == "retired" ? PatchLife::kRetired : PatchLife::kActive;
  patch.retired_reason = row.getColumn(kRetiredReason).getString();
  patch.retired_on = TextOf(row.getColumn(kRetiredOn));
  patch.superseded_by = row.getColumn(kSupersededBy).getInt64();
  patch.epoch = row.getColumn(kEpoch).getInt();
  patch.created = TextOf(row.getColumn(kCreated));
  patch.views = row.getColumn(kViews).getInt();
  patch.success_weight = row.getColumn(kSuccessWeight).getDouble();
  patch.failure_weight = row.getColumn(kFailureWeight).getDouble();
}

PackedPatch PackedPatchOf(const SQLite::Statement& row) {
  PackedPatch packed;
  Patch& patch = packed.patch;
  patch.id = row.getColumn(kId).getInt64();
  const Bytes geometry = BytesOf(row.getColumn(kGeom));
  const auto ground = DecodePointZ(geometry.data(), geometry.size());
  if (!ground) throw InputError("its geometry is not a POINT Z");
  patch.ground_m = *ground;
  patch.source_id = row.getColumn(kSourceId).getInt64();
  patch.gsd_m = RequiredNumberOf(row.getColumn(kGsd));
  if (!IsBetween(patch.gsd_m, kLeastLength_m, kGreatestLength_m))
    throw InputError(fmt::format("its gsd_m is {}", patch.gsd_m));
  patch.bits = row.getColumn(kBits).getInt();
  if (!row.getColumn(kChipMask).isNull()) packed.mask = BytesOf(row.getColumn(kChipMask));
  packed.chip = BytesOf(row.getColumn(kChip));
  packed.heights = HeightsOf(row);
  patch.covariance_m2 = DecodeCovariance(BytesOf(row.getColumn(kCovariance)));
  if (!(patch.covariance_m2.diagonal().maxCoeff() <= kGreatestPatchSigma_m * kGreatestPatchSigma_m))
    throw InputError(fmt::format("its covariance is of {:g} m",
                                 std::sqrt(patch.covariance_m2.diagonal().maxCoeff())));
  if (!row.getColumn(kHeightEffect).isNull()) {
    patch.height_effect = DecodeVector(BytesOf(row.getColumn(kHeightEffect)));
    if (!(patch.height_effect->cwiseAbs().maxCoeff() <= kGreatestEffect))
      throw InputError(
          fmt::format("its height_effect is {:g}", patch.height_effect->cwiseAbs().maxCoeff()));
  }
  patch.height_sigma_m = CheckedNumberOf(row.getColumn(kHeightSigma));
  if (patch.height_sigma_m && !IsBetween(*patch.height_sigma_m, 0, kGreatestPatchSigma_m))
    throw InputError(fmt::format("its height_sigma_m is {}", *patch.height_sigma_m));
  ReadQualities(row, patch);
  ReadLife(row, patch);
  return packed;
}

template <typename Work>
auto OfPatch(std::int64_t id, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(fmt::format("patch {} is damaged: {}", id, error.what()));
  }
}

}  // namespace

void CheckPatch(const Patch& patch) {
  if (patch.chip.width < 1 || patch.chip.height < 1 || patch.chip.width > 4096 ||
      patch.chip.height > 4096)
    throw std::invalid_argument("a patch needs a chip of 1 to 4096 pixels per side");
  if (!patch.colour.empty() &&
      (patch.colour.size() != 3 ||
       std::any_of(patch.colour.begin(), patch.colour.end(), [&](const Image& band) {
         return band.width != patch.chip.width || band.height != patch.chip.height;
       })))
    throw std::invalid_argument("a patch's colour is three bands of its chip's size");
  if (patch.bits != 8 && patch.bits != 16)
    throw std::invalid_argument("a patch's bits are 8 or 16");
  if (!patch.ground_m.allFinite() || !patch.covariance_m2.allFinite() || !(patch.gsd_m > 0))
    throw std::invalid_argument("a patch needs a finite position, covariance and pixel size");
  const double most_m2 = kGreatestPatchSigma_m * kGreatestPatchSigma_m;
  if (patch.covariance_m2.diagonal().maxCoeff() > most_m2)
    throw std::invalid_argument("a patch's sigma is at most 10 km");
  const HeightGrid& heights = patch.heights;
  const auto nodes =
      static_cast<std::size_t>(heights.size) * static_cast<std::size_t>(heights.size);
  if (heights.size < 0 || heights.heights_m.size() != nodes)
    throw std::invalid_argument("a patch's heights do not fit their size");
  if (heights.size > 0 && (heights.size % 2 == 0 || !(heights.step_m > 0)))
    throw std::invalid_argument("a patch's heights need an odd size and a positive step");
}

void BindPatch(const Patch& patch, int srs_id, SQLite::Statement& statement) {
  BindBlob(statement, kGeom + 1, EncodePointZ(patch.ground_m, srs_id));
  statement.bind(kGsd + 1, patch.gsd_m);
  statement.bind(kBits + 1, patch.bits);
  statement.bind(kBands + 1, patch.colour.empty() ? 1 : 3);
  BindBlob(statement, kCovariance + 1, EncodeCovariance(patch.covariance_m2));
  if (patch.height_effect)
    BindBlob(statement, kHeightEffect + 1, EncodeVector(*patch.height_effect));
  BindOptional(statement, kHeightSigma + 1, patch.height_sigma_m);
  BindOptional(statement, kRoundness + 1, patch.roundness);
  BindOptional(statement, kDistinctness + 1, patch.distinctness);
  BindOptional(statement, kSecondPeak + 1, patch.second_peak_px);
  BindOptional(statement, kPersistence + 1, patch.persistence);
  BindOptional(statement, kRelief + 1, patch.relief_px);
  BindOptional(statement, kLean + 1, patch.lean_px);
  if (patch.energy)
    for (int i = 0; i < 3; ++i) statement.bind(kEnergyXx + 1 + i, (*patch.energy)[i]);
  BindOptional(statement, kQuality + 1, patch.quality);
  BindHeights(patch, statement);
  if (const auto mask = EncodeChipMask(patch.chip)) BindBlob(statement, kChipMask + 1, *mask);
  BindBlob(statement, kChip + 1,
           patch.colour.empty() ? EncodeChip(patch.chip, patch.bits)
                                : EncodeColourChip(patch.colour, patch.bits));
}

PackedPatch ReadPatchRow(const SQLite::Statement& row) {
  return OfPatch(row.getColumn(kId).getInt64(), [&] { return PackedPatchOf(row); });
}

Patch Unpack(PackedPatch packed, bool with_colour) {
  return OfPatch(packed.patch.id, [&] {
    packed.patch.chip = DecodeChip(packed.chip, packed.mask);
    if (with_colour) packed.patch.colour = DecodeColour(packed.chip, packed.mask);
    packed.patch.heights = Unpacked(packed.heights);
    return std::move(packed.patch);
  });
}

PatchEvidence ReadEvidenceRow(const SQLite::Statement& row) {
  return {row.getColumn(0).getInt64(), PixelOf(row, 1), PixelOf(row, 3)};
}

PatchSource ReadSourceRow(const SQLite::Statement& row) {
  PatchSource source;
  source.id = row.getColumn(0).getInt64();
  const std::string kind = row.getColumn(1).getString();
  for (const SourceKind known : {SourceKind::kPhoto, SourceKind::kOrthophoto, SourceKind::kGcp})
    if (kind == Name(known)) source.kind = known;
  source.name = row.getColumn(2).getString();
  source.date = TextOf(row.getColumn(3));
  source.gsd_m = row.getColumn(4).getDouble();
  source.crs = TextOf(row.getColumn(5));
  source.provenance = TextOf(row.getColumn(6));
  source.licence = TextOf(row.getColumn(7));
  source.digest = TextOf(row.getColumn(8));
  return source;
}

void BindSource(const PatchSource& source, bool harvested, SQLite::Statement& insert) {
  insert.bind(1, Name(source.kind));
  insert.bind(2, source.name);
  BindOptional(insert, 3, source.date);
  insert.bind(4, source.gsd_m);
  BindOptional(insert, 5, source.crs);
  BindOptional(insert, 6, source.provenance);
  BindOptional(insert, 7, source.licence);
  BindOptional(insert, 8, source.digest);
  insert.bind(9, harvested ? 1 : 0);
}

void BindEvidence(std::int64_t patch_id, std::int64_t source_id, const PatchEvidence& evidence,
                  SQLite::Statement& insert) {
  insert.bind(1, patch_id);
  insert.bind(2, source_id);
  BindPixel(insert, 3, evidence.pixel);
  BindPixel(insert, 5, evidence.residual_px);
}

void BindAttempt(const MatchAttempt& attempt, SQLite::Statement& insert) {
  insert.bind(1, attempt.patch_id);
  insert.bind(2, attempt.photo);
  insert.bind(3, attempt.state);
  BindOptional(insert, 4, attempt.ncc);
  BindPixel(insert, 5, attempt.residual_px);
  insert.bind(7, attempt.reason);
  BindOptional(insert, 8, attempt.photo_date);
  BindOptional(insert, 9, attempt.photo_status);
  BindPixel(insert, 10, attempt.predicted_px);
  BindPixel(insert, 12, attempt.found_px);
  insert.bind(14, attempt.photo_digest);
}

}  // namespace orient::patchdb
