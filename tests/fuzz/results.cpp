// Files that the program writes and reads again: results, files passed between stages.
#include "core/files/results.h"

#include "block/inputs/photo_interior.h"
#include "block/stages/keypoint_file.h"
#include "block/ties/tie_file.h"
#include "core/base/atomic_write.h"
#include "core/files/adjustment_result.h"
#include "core/files/interior_table.h"
#include "tests/fuzz/reader.h"
#include "tools/convert/export_record.h"

namespace orient::fuzz {
namespace {

// The result is written and read again; writing it once more must give the same bytes.
template <typename Result>
void RequireTheSameAgain(const Result& result, const std::string& path,
                         const std::function<void(const Result&)>& write,
                         const std::function<Result(const std::string&)>& read) {
  write(result);
  const std::string text = ReadFile(path);
  write(read(path));
  Require(ReadFile(path) == text, text);
}

const Register kInteriorResult("interior_result", [](Input input) {
  InteriorResult result = ReadInteriorResult(FileWith("read.json", Text(input)));
  Require(result.photo.find('/') == std::string::npos, "a photo's name is no path");
  InteriorTable({result});
  if (result.photo_from_pixel) {
    const auto correction = block::CorrectionOf(result);
    PixelFromPhoto(*result.photo_from_pixel, correction.get(), {1, 2});
  }
  Sentences(result.findings);
  result.photo = "photo";
  RequireTheSameAgain<InteriorResult>(
      result, InteriorResultPath(Folder(), "photo"),
      [](const InteriorResult& of) { WriteInteriorResult(Folder(), of); }, ReadInteriorResult);
});

const Register kExteriorResult("exterior_result", [](Input input) {
  ExteriorResult result = ReadExteriorResult(FileWith("read.json", Text(input)));
  Sentences(result.findings);
  result.photo = "photo";
  RequireTheSameAgain<ExteriorResult>(
      result, ExteriorResultPath(Folder(), "photo"),
      [](const ExteriorResult& of) { WriteExteriorResult(Folder(), of); }, ReadExteriorResult);
});

const Register kBlockResult("block_result", [](Input input) {
  const AdjustmentResult result = ReadAdjustmentResult(FileWith("read.json", Text(input)));
  result.CheckRmsPx();
  RequireTheSameAgain<AdjustmentResult>(
      result, AdjustmentResultPath(Folder()),
      [](const AdjustmentResult& of) { WriteAdjustmentResult(Folder(), of); },
      ReadAdjustmentResult);
});

// Each reader is given the files of all stages.
const Register kStageFile("stage_file", [](Input input) {
  const std::string path = FileWith("stage.json", Text(input));
  const Inputs made_from = ReadMadeFrom(path).value_or(Inputs());
  TextOfInputs(WhatChanged(made_from, {{"scan", "x"}}));
  if (const auto ties = Accepted([&] { return block::ReadTieFile(path); })) {
    const std::string again = Folder() + "/again.ties.json";
    block::WriteTieFile(again, "photo", made_from, *ties);
    Require(block::ReadTieFile(again).size() == ties->size(), "as many ties again");
  }
  if (const auto found = Accepted([&] { return block::ReadKeypointResult(path, "photo"); })) {
    const std::string again = Folder() + "/again.keypoints.json";
    block::WriteKeypointResult(again, made_from, *found);
    Require(block::ReadKeypointResult(again, "photo").has_value() == found->has_value(),
            "found again");
  }
});

// export.json and verification.csv.
const Register kExportRecord("export_record", [](Input input) {
  const auto parts = Parts(input);
  FileWith("export.json", parts[0]);
  if (const auto record = Accepted([] { return ReadExportRecord(Folder()); }))
    WriteExportRecord(Folder(), *record);
  const auto rows = ReadVerification(FileWith("verification.csv", parts.back()));
  WriteVerification(Folder(), rows);
  Require(ReadVerification(VerificationPath(Folder())).size() == rows.size(), "as many rows again");
});

}  // namespace
}  // namespace orient::fuzz
