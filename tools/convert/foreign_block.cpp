#include "tools/convert/foreign_block.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/exchange/asp_pinhole.h"
#include "core/exchange/colmap.h"
#include "core/exchange/frame_adjustments.h"
#include "core/exchange/metashape.h"
#include "core/exchange/micmac_orientation.h"
#include "core/exchange/opensfm.h"
#include "tools/convert/metashape_ground.h"
#include "tools/convert/opensfm_ground.h"

namespace orient {
namespace {

ExchangeBlock OpensfmBlock(const std::string& input, const ForeignOptions& options,
                           std::vector<std::string>* messages) {
  OpensfmReconstruction read = ReadOpensfm(input);
  if (!read.reference_lla)
    throw InputError(input + ": reconstruction.json lacks reference_lla: where the " +
                     "reconstruction lies on the earth is not known");
  if (read.others > 0)
    messages->push_back(
        fmt::format("the first of {} reconstructions was read; each of the others "
                    "has a system of its own",
                    read.others + 1));
  return ExchangeFromOpensfm(
      TopocentricOpensfm(std::move(read), {input, options.crs, options.offset}, messages));
}

// export.json's, else the comments'.
std::optional<Eigen::Vector3d> OriginOfColmap(const std::string& input,
                                              const ExportRecord& record) {
  return record.format.empty() ? ReadColmapOrigin(input) : record.origin;
}

}  // namespace

ForeignBlock ReadForeignBlock(ExchangeFormat format, const std::string& input,
                              const ExportRecord& record, const ForeignOptions& options) {
  ForeignBlock foreign;
  switch (format) {
    case ExchangeFormat::kOpk:
      throw std::invalid_argument("ReadForeignBlock: an OPK table is Orient's own");
    case ExchangeFormat::kOri:
      foreign.block = ExchangeFromOri(ReadOri(input));
      break;
    case ExchangeFormat::kPatb:
      foreign.block = ExchangeFromPatb(ReadPatb(input), ReadPhotoNumbers(input));
      break;
    case ExchangeFormat::kBingo:
      foreign.block = ExchangeFromBingo(ReadBingo(input), ReadPhotoNumbers(input));
      break;
    case ExchangeFormat::kMicmac:
      foreign.block = ExchangeFromMicmac(ReadMicmacOrientation(input));
      break;
    case ExchangeFormat::kMetashape: {
      const MetashapeChunk chunk = ReadMetashape(input);
      foreign.messages = NotesOnMetashape(chunk, input);
      foreign.if_misplaced =
          chunk.placed ? "the chunk's transform does not lead into that CRS; name the right one "
                         "with --crs, or georeference the chunk in Metashape and export again"
                       : "the chunk has no transform; georeference it in Metashape and export its "
                         "cameras again";
      foreign.block = ExchangeFromMetashape(chunk);
      foreign.geocentric = IsGeocentric(chunk);
      break;
    }
    case ExchangeFormat::kColmap: {
      foreign.block = ExchangeFromColmap(ReadColmap(input));
      const auto origin = OriginOfColmap(input, record);
      foreign.frame_origin = origin.value_or(Eigen::Vector3d::Zero());
      foreign.origin_unknown = !origin;
      break;
    }
    case ExchangeFormat::kOpensfm:
      foreign.block = OpensfmBlock(input, options, &foreign.messages);
      foreign.if_misplaced = "reference_lla lies elsewhere; name the right CRS with --crs";
      break;
    case ExchangeFormat::kAsp:
      foreign.block = ExchangeFromAsp(ReadAsp(input));
      foreign.if_misplaced =
          "the cameras' C is not geocentric; bring it there (ASP's bundle_adjust)";
      foreign.geocentric = true;
      break;
  }
  RequireSound(foreign.block, input);
  return foreign;
}

}  // namespace orient
