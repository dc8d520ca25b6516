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
      foreign.block = ExchangeFromMetashape(chunk);
      foreign.geocentric = IsGeocentric(chunk);
      break;
    }
    case ExchangeFormat::kColmap:
      foreign.block = ExchangeFromColmap(ReadColmap(input));
      foreign.frame_origin = record.origin;
      break;
    case ExchangeFormat::kOpensfm:
      foreign.block = OpensfmBlock(input, options, &foreign.messages);
      break;
    case ExchangeFormat::kAsp:
      foreign.block = ExchangeFromAsp(ReadAsp(input));
      foreign.geocentric = true;
      break;
  }
  RequireSound(foreign.block, input);
  return foreign;
}

}  // namespace orient
