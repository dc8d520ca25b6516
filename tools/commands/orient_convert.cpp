// orient convert: exports oriented blocks to other programs, imports theirs, and checks exports.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <ostream>

#include "block/block_folder.h"
#include "block/inputs/camera_library.h"
#include "block/stages/exterior_stage.h"
#include "core/base/error.h"
#include "core/base/trimmed.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "core/files/toml_fields.h"
#include "tools/commands/commands.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"
#include "tools/convert/check_exports.h"
#include "tools/convert/convert_source.h"
#include "tools/convert/export_record.h"
#include "tools/convert/program_folders.h"
#include "tools/convert/resample_photos.h"
#include "tools/convert/write_exports.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> FormatNames() {
  std::vector<std::string> names;
  for (const ExchangeFormat format : kAllExchangeFormats) names.push_back(Name(format));
  return names;
}

// Makes of "COLMAP" or " colmap" what the format is called; CLI11 says which option was wrong.
CLI::Validator FormatName() {
  const auto known = [](std::string& name) -> std::string {
    std::string word(Trimmed(name));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (ExchangeFormatFromName(word)) {
      name = word;
      return "";
    }
    const std::vector<std::string> names = FormatNames();
    const std::string nearest = NearestWord(word, {names.begin(), names.end()});
    return fmt::format("\"{}\" is no format; {}", name,
                       nearest.empty() ? fmt::format("formats are {}", fmt::join(names, ", "))
                                       : "did you mean " + nearest + "?");
  };
  return {known, fmt::format("{{{}}}", fmt::join(FormatNames(), ",")), "format"};
}

class ConvertCommand : public Command {
 public:
  std::string Name() const override { return "convert"; }
  std::string Summary() const override {
    return "Convert oriented blocks to and from other programs' files, and check such files";
  }

  void Setup(CLI::App& app) override {
    app.add_option("INPUT", source_.input,
                   "Folder of 'orient block' or 'orient exterior', an OPK CSV, or another "
                   "program's folder or file")
        ->required();
    app.add_option("--from", from_, "The input's format")
        ->transform(FormatName())
        ->default_str("opk");
    app.add_option("--to", to_, "Formats to write, each into its own folder")
        ->transform(FormatName())
        ->delimiter(',')
        ->allow_extra_args(false);
    app.add_option("--camera", source_.camera,
                   "Camera file (TOML) or a name from the camera library; for other programs' "
                   "files, the camera of their images");
    AddCameraLibraryOption(app, &library_);
    app.add_option("--interior", source_.interior,
                   "Folder with the results of 'orient interior' (default: INPUT)");
    app.add_option(
        "--images", images_,
        "The photos (globs are expanded), for OUT/images and the programs' folders: scans "
        "of film are resampled into the photo system, digital images linked");
    app.add_option("--pixel-size-um", source_.pixel_size_um,
                   "Pixel size of film photos' images (default: the scans' mean)")
        ->check(CLI::Range(0.5, 1000.0));
    app.add_flag("--remove-distortion", source_.remove_distortion,
                 "Also remove the lens distortion from film photos' images");
    app.add_option("--image-extension", source_.image_extension,
                   "Extension of the images' names in the files written")
        ->capture_default_str();
    app.add_option("--crs", source_.crs, "The block's CRS, if no .prj names it");
    app.add_option("--geoid-m", source_.geoid_m,
                   "Height of the geoid above the ellipsoid, added to heights for geocentric and "
                   "topocentric formats (default 0)");
    app.add_option("--ground-height-m", source_.ground_height_m,
                   "Mean ground height, if the input does not give it");
    app.add_option("--origin", origin_,
                   "Origin subtracted from ground coordinates (COLMAP, Metashape, OpenSfM)")
        ->expected(3);
    app.add_option("--offset", offset_,
                   "With --from opensfm: the poses are projected, minus this X Y (OpenDroneMap)")
        ->expected(2);
    app.add_flag("--check", check_,
                 "Project the verification points of INPUT's exports by their programs' formulas, "
                 "and name conventions that do not fit");
    app.add_option("--points", points_,
                   "Verification points (default: verification.csv beside the files)");
    app.add_option("--out", out_, "Folder for the results; created if missing");
    AddOverwriteOption(app, &overwrite_);
  }

  ExitCode Run(std::ostream& out) override {
    if (check_ && (!to_.empty() || !images_.empty() || !out_.empty() || overwrite_))
      throw UsageError(
          "--check reads files that are there: give it without --to, --images, --out and "
          "--overwrite");
    if (!check_ && !points_.empty()) throw UsageError("--points needs --check");
    if (check_) return Check(out);
    if (to_.empty() && images_.empty())
      throw UsageError("give --to or --images to write files, or --check to check them");
    if (out_.empty()) throw UsageError("name a folder for the results with --out");
    Prepare();
    const ConvertSource source = Read();
    if (const auto note = block::UnfinishedNote(FolderOf(source_.input)))
      out << "note: " << *note << "\n";
    for (const std::string& message : source.messages) out << "note: " << message << "\n";
    if (!images_.empty() && !IsFilm(source)) RequireDigitalImages(images_, source_.image_extension);
    if (!to_.empty()) Write(source, out);
    const bool all = images_.empty() || MakeImages(source, out);
    RecordRun(Invoked(), out_, "convert", {Input(), FileInput("camera", source_.camera)});
    return all ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
  }

 private:
  // For Orient's own results, the folder's table; another program's folder has no single file.
  RunInput Input() const {
    const std::string table = block::PoseTablePath(source_.input);
    if (fs::is_regular_file(table)) return FileInput("poses", table);
    return fs::is_directory(source_.input) ? RunInput{"input", source_.input, ""}
                                           : FileInput("input", source_.input);
  }

  ExchangeFormat From() const { return *ExchangeFormatFromName(from_.empty() ? "opk" : from_); }

  // Requires --from for a folder that an earlier call made for another program.
  void RequireFrom() const {
    if (!from_.empty() || fs::is_regular_file(block::PoseTablePath(source_.input)) ||
        fs::path(source_.input).extension() == ".csv")
      return;
    const std::string format = ReadExportRecord(FolderOf(source_.input)).format;
    if (!format.empty() && format != "opk")
      throw UsageError(
          fmt::format("{} holds {} files: add --from {}", source_.input, format, format));
  }

  void Prepare() {
    RequireFrom();
    if (!source_.camera.empty()) source_.camera = block::FindCameraFile(source_.camera, library_);
    if (!origin_.empty()) source_.origin = Eigen::Vector3d(origin_.data());
    if (!offset_.empty()) {
      if (From() != ExchangeFormat::kOpensfm)
        throw UsageError("--offset needs --from opensfm; other formats take --origin");
      source_.opensfm_offset = Eigen::Vector2d(offset_.data());
    }
    RequirePlausible();
    if (!source_.image_extension.empty() && source_.image_extension.front() != '.')
      source_.image_extension.insert(0, ".");
    std::vector<std::string> results;
    for (const ExchangeFormat format : Formats())
      results.push_back(ExportDirectory(Export(), format));
    if (!images_.empty()) {
      if (From() != ExchangeFormat::kOpk)
        throw UsageError("--images needs Orient's own results as INPUT");
      images_ = ExpandPhotos(images_, "");
      for (const std::string& scan : images_) results.push_back(ImagePath(scan));
      results.push_back((fs::path(out_) / "images" / "camera.toml").string());
    }
    std::vector<std::string> inputs = images_;
    inputs.push_back(source_.input);
    inputs.push_back(source_.camera);
    RefuseToReplaceInputs(results, inputs);
    RefuseToOverwrite(results, overwrite_);
  }

  void RequirePlausible() const {
    const auto require = [](const char* option, double value, double most) {
      if (!(std::abs(value) <= most))
        throw UsageError(fmt::format("{} is {:g}; it must lie between {:.0f} and {:.0f} m", option,
                                     value, -most, most));
    };
    for (const double coordinate : origin_) require("--origin", coordinate, 1e8);
    for (const double coordinate : offset_) require("--offset", coordinate, 1e8);
    require("--geoid-m", source_.geoid_m.value_or(0), 200);
    require("--ground-height-m", source_.ground_height_m.value_or(0), 1e4);
  }

  ConvertSource Read() const { return ReadForeign(From(), source_); }

  std::vector<ExchangeFormat> Formats() const {
    std::vector<ExchangeFormat> formats;
    for (const std::string& name : to_) {
      const ExchangeFormat format = *ExchangeFormatFromName(name);
      if (std::find(formats.begin(), formats.end(), format) == formats.end())
        formats.push_back(format);
    }
    return formats;
  }

  ExportOptions Export() const {
    return {Formats(), out_, source_.geoid_m.value_or(0), source_.origin};
  }

  std::string ImagePath(const std::string& scan) const {
    return (fs::path(out_) / "images" / (PhotoName(scan) + ".tif")).string();
  }

  void Write(const ConvertSource& source, std::ostream& out) const {
    for (const WrittenExport& written : WriteExports(source, Export())) {
      const auto control = std::count_if(source.block.points.begin(), source.block.points.end(),
                                         [](const ExchangePoint& point) { return point.control; });
      out << written.directory << ": " << source.block.photos.size() << " photos, " << control
          << " control points, " << source.block.points.size() - static_cast<std::size_t>(control)
          << " tie points\n  " << Verdict(written.check) << "\n";
      for (const std::string& note : NotesOn(written, source)) out << "  " << note << "\n";
    }
  }

  static bool IsFilm(const ConvertSource& source) {
    return source.camera_of_poses->camera.kind == CameraKind::kFilm;
  }

  // Returns whether all could be made.
  bool MakeImages(const ConvertSource& source, std::ostream& out) const {
    const bool all = !IsFilm(source) || Resample(source, out);
    if (!IsFilm(source)) LinkDigitalImages(out_, images_, source_.image_extension);
    LinkImagesForPrograms(out_, Formats(), source.block);
    return all;
  }

  bool Resample(const ConvertSource& source, std::ostream& out) const {
    const std::string interior = source_.interior.value_or(FolderOf(source_.input));
    const std::string folder = (fs::path(out_) / "images").string();
    MakeOutputDirectory(folder);
    WriteCameraFile((fs::path(folder) / "camera.toml").string(),
                    {source.cameras.front(), {}, {}, std::nullopt, {}});
    ProgressLine progress("resampling", static_cast<int>(images_.size()));
    bool all = true;
    for (const std::string& scan : images_) {
      try {
        const ResampledPhoto made = ResampleOne(source, interior, scan);
        out << fmt::format("{}: {} x {} px, {} bands, largest difference {:.2g} px\n", made.path,
                           made.width, made.height, made.bands, made.largest_difference_px);
      } catch (const InputError& error) {
        out << "failed  " << PhotoName(scan) << ": " << error.what() << "\n";
        all = false;
      }
      progress.Advance();
    }
    progress.Finish();
    return all;
  }

  ResampledPhoto ResampleOne(const ConvertSource& source, const std::string& interior,
                             const std::string& scan) const {
    const std::string photo = PhotoName(scan);
    if (!fs::exists(InteriorResultPath(interior, photo)))
      throw InputError(interior + " holds no interior orientation of " + scan +
                       "; name the folder that does with --interior, or leave the photo out");
    const std::string exterior = ExteriorResultPath(FolderOf(source_.input), photo);
    std::optional<ScanOrientation> orientation;
    if (fs::exists(exterior)) orientation = ReadExteriorResult(exterior).orientation;
    const FilmImage film(*source.camera_of_poses, photo, interior, orientation,
                         source.cameras.front(), source_.remove_distortion);
    return ResamplePhoto(scan, film, source.cameras.front(), ImagePath(scan));
  }

  ExitCode Check(std::ostream& out) const {
    bool all = true;
    std::optional<ExchangeFormat> format;
    if (!from_.empty()) format = From();
    const bool one = !points_.empty() || format;
    for (const std::string& folder :
         one ? std::vector<std::string>{source_.input} : ExportFolders(source_.input)) {
      const ExportCheck check = CheckExport(folder, format, points_);
      out << folder << ": " << Verdict(check) << "\n";
      all = all && check.ok;
    }
    return all ? ExitCode::kAllDone : ExitCode::kBadInput;
  }

  ConvertSourceOptions source_;
  std::string from_, library_, points_, out_;
  std::vector<std::string> to_, images_;
  std::vector<double> origin_, offset_;
  bool check_ = false, overwrite_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeConvertCommand() { return std::make_unique<ConvertCommand>(); }

}  // namespace orient
