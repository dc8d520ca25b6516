#include "patchdb/patch_rows.h"

#include <stdexcept>

#include "core/error.h"
#include "patchdb/geopackage_geometry.h"
#include "patchdb/patch_blobs.h"

namespace orient {
namespace {

void BindBlob(SQLite::Statement& statement, int index, const Bytes& bytes) {
  statement.bind(index, static_cast<const void*>(bytes.data()), static_cast<int>(bytes.size()));
}

void BindOptional(SQLite::Statement& statement, int index, const std::optional<double>& value) {
  if (value)
    statement.bind(index, *value);
  else
    statement.bind(index);
}

Bytes BlobOf(const SQLite::Column& column) {
  const auto* bytes = static_cast<const unsigned char*>(column.getBlob());
  return bytes == nullptr ? Bytes() : Bytes(bytes, bytes + column.getBytes());
}

std::optional<double> OptionalOf(const SQLite::Column& column) {
  if (column.isNull()) return std::nullopt;
  return column.getDouble();
}

// Columns of the SELECT in patchdb/statements.h.
enum PatchColumn {
  kId,
  kGeom,
  kSourceId,
  kGsd,
  kBits,
  kChip,
  kChipMask,
  kHeights,
  kHeightsSize,
  kHeightsStep,
  kCovariance,
  kRoundness,
  kDistinctness,
  kPersistence,
  kRelief,
  kHeightEffect,
  kHeightSigma
};

Patch DecodePatchRow(const SQLite::Statement& row) {
  Patch patch;
  patch.id = row.getColumn(kId).getInt64();
  const Bytes geometry = BlobOf(row.getColumn(kGeom));
  const auto ground = DecodePointZ(geometry.data(), geometry.size());
  if (!ground) throw InputError("its geometry is not a POINT Z");
  patch.ground_m = *ground;
  patch.source_id = row.getColumn(kSourceId).getInt64();
  patch.gsd_m = row.getColumn(kGsd).getDouble();
  if (!(patch.gsd_m > 0) || !std::isfinite(patch.gsd_m))
    throw InputError("its gsd_m is not positive");
  patch.bits = row.getColumn(kBits).getInt();
  std::optional<Bytes> mask;
  if (!row.getColumn(kChipMask).isNull()) mask = BlobOf(row.getColumn(kChipMask));
  patch.chip = DecodeChip(BlobOf(row.getColumn(kChip)), mask);
  if (!row.getColumn(kHeights).isNull())
    patch.heights =
        DecodeHeights(BlobOf(row.getColumn(kHeights)), row.getColumn(kHeightsSize).getInt(),
                      row.getColumn(kHeightsStep).getDouble());
  patch.covariance_m2 = DecodeCovariance(BlobOf(row.getColumn(kCovariance)));
  patch.roundness = OptionalOf(row.getColumn(kRoundness));
  patch.distinctness = OptionalOf(row.getColumn(kDistinctness));
  patch.persistence = OptionalOf(row.getColumn(kPersistence));
  patch.relief_px = OptionalOf(row.getColumn(kRelief));
  if (!row.getColumn(kHeightEffect).isNull())
    patch.height_effect = DecodeVector(BlobOf(row.getColumn(kHeightEffect)));
  patch.height_sigma_m = OptionalOf(row.getColumn(kHeightSigma));
  return patch;
}

}  // namespace

const char* Name(SourceKind kind) { return kind == SourceKind::kPhoto ? "photo" : "orthophoto"; }

void CheckPatch(const Patch& patch) {
  if (patch.chip.width < 1 || patch.chip.height < 1 || patch.chip.width > 4096 ||
      patch.chip.height > 4096)
    throw std::invalid_argument("a patch needs a chip of 1 to 4096 pixels a side");
  if (patch.bits != 8 && patch.bits != 16)
    throw std::invalid_argument("a patch's bits are 8 or 16");
  if (!patch.ground_m.allFinite() || !patch.covariance_m2.allFinite() || !(patch.gsd_m > 0))
    throw std::invalid_argument("a patch needs a finite position, covariance and pixel size");
  const HeightGrid& heights = patch.heights;
  const auto nodes =
      static_cast<std::size_t>(heights.size) * static_cast<std::size_t>(heights.size);
  if (heights.size < 0 || heights.heights_m.size() != nodes)
    throw std::invalid_argument("a patch's heights do not fit their size");
  if (heights.size > 0 && (heights.size % 2 == 0 || !(heights.step_m > 0)))
    throw std::invalid_argument("a patch's heights need an odd size and a positive step");
}

void BindPatch(const Patch& patch, std::int64_t source_id, int srs_id, SQLite::Statement& insert) {
  BindBlob(insert, 1, EncodePointZ(patch.ground_m, srs_id));
  insert.bind(2, source_id);
  insert.bind(3, patch.gsd_m);
  insert.bind(4, patch.bits);
  BindBlob(insert, 5, EncodeChip(patch.chip, patch.bits));
  if (const auto mask = EncodeChipMask(patch.chip)) BindBlob(insert, 6, *mask);
  if (patch.heights.size > 0) {
    BindBlob(insert, 7, EncodeHeights(patch.heights));
    insert.bind(8, patch.heights.size);
    insert.bind(9, patch.heights.step_m);
  }
  BindBlob(insert, 10, EncodeCovariance(patch.covariance_m2));
  BindOptional(insert, 11, patch.roundness);
  BindOptional(insert, 12, patch.distinctness);
  BindOptional(insert, 13, patch.persistence);
  BindOptional(insert, 14, patch.relief_px);
  if (patch.height_effect) BindBlob(insert, 15, EncodeVector(*patch.height_effect));
  BindOptional(insert, 16, patch.height_sigma_m);
}

Patch ReadPatchRow(const SQLite::Statement& row) {
  try {
    return DecodePatchRow(row);
  } catch (const InputError& error) {
    throw InputError("patch " + std::to_string(row.getColumn(kId).getInt64()) +
                     " is damaged: " + error.what());
  }
}

PatchSource ReadSourceRow(const SQLite::Statement& row) {
  PatchSource source;
  source.id = row.getColumn(0).getInt64();
  source.kind = row.getColumn(1).getString() == Name(SourceKind::kPhoto) ? SourceKind::kPhoto
                                                                         : SourceKind::kOrthophoto;
  source.name = row.getColumn(2).getString();
  if (!row.getColumn(3).isNull()) source.date = row.getColumn(3).getString();
  source.gsd_m = row.getColumn(4).getDouble();
  return source;
}

void BindAttempt(const MatchAttempt& attempt, SQLite::Statement& insert) {
  insert.bind(1, attempt.patch_id);
  insert.bind(2, attempt.photo);
  insert.bind(3, attempt.state);
  BindOptional(insert, 4, attempt.ncc);
  if (attempt.residual_px) {
    insert.bind(5, attempt.residual_px->x());
    insert.bind(6, attempt.residual_px->y());
  }
  insert.bind(7, attempt.reason);
}

}  // namespace orient
