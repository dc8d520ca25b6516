#include "tools/commands/ortho_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <ostream>
#include <utility>

#include "block/inputs/approximations.h"
#include "block/inputs/block_files.h"
#include "block/plan.h"
#include "core/base/atomic_write.h"
#include "core/base/csv_cell.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/base/output_directory.h"
#include "core/raster/band_raster.h"
#include "ortho/mosaic.h"
#include "ortho/mosaic_cells.h"
#include "ortho/seam_search.h"
#include "ortho/tone_balance.h"
#include "tools/commands/command.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"
#include "tools/report/figures/ortho_figures.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kOrtho = ".ortho.tif";  // after the photo's name
constexpr const char* kMosaic = "mosaic.tif";
constexpr const char* kSeams = "seamlines.gpkg";
constexpr const char* kTones = "mosaic_tones.csv";
constexpr const char* kSoftware = "TIFFTAG_SOFTWARE";

class OrthoRun {
 public:
  explicit OrthoRun(const OrthoRunOptions& options) : options_(options) {}

  bool Do(std::ostream& out) {
    const OrthoPhotos found = ReadOrthoPhotos(options_.source);
    for (const std::string& why : found.left_out) out << "left out  " << why << "\n";
    if (found.photos.empty()) throw InputError("no photo to make an orthophoto of");
    RefuseToReplace(found);
    const double gsd_m = options_.gsd_m ? *options_.gsd_m : NaturalGsd(found);
    if (options_.plan) {
      TellPlan(found, gsd_m, out);
      return found.left_out.empty();
    }
    // Errors in given seamlines are reported before an hour's work.
    const std::string given = GivenSeams();
    if (options_.mosaic && !given.empty())
      seamlines_ = ortho::Seamlines::FromFile(given, found.crs);
    MakeOutputDirectory(options_.out);
    const FolderLock lock(options_.out, block::kBlockLock);
    bool all = found.left_out.empty();
    std::vector<ortho::MosaicPart> parts;
    for (std::size_t i = 0; i < found.photos.size(); ++i) {
      try {
        parts.push_back(MakeOne(found, i, gsd_m, out));
      } catch (const InputError& error) {
        out << "failed    " << found.photos[i].name << ": " << error.what() << "\n";
        all = false;
      }
    }
    TellDemsEnd(out);
    if (options_.mosaic && !parts.empty())
      MakeMosaic(found, parts, out);
    else
      TellOldMosaic(out);
    return all;
  }

 private:
  std::string PathOf(const std::string& file) const {
    return (fs::path(options_.out) / file).string();
  }
  std::string SeamsPath() const { return PathOf(kSeams); }
  std::string TonesPath() const { return PathOf(kTones); }
  std::string OrthoPath(const std::string& photo) const { return PathOf(photo + kOrtho); }

  void RefuseToReplace(const OrthoPhotos& found) const {
    std::vector<std::string> results;
    for (const ortho::OrientedPhoto& photo : found.photos) results.push_back(OrthoPath(photo.name));
    if (options_.mosaic) results.push_back(PathOf(kMosaic));
    if (options_.mosaic && options_.seams.empty()) results.push_back(SeamsPath());
    if (options_.balance) results.push_back(TonesPath());
    std::vector<std::string> inputs = options_.source.scans;
    for (const std::string& input :
         {options_.source.poses, options_.source.dem, options_.source.camera})
      inputs.push_back(input);
    RefuseToReplaceInputs(results, inputs);
    RefuseOthersOrthophotos(found);
    RefuseToOverwrite(results, options_.overwrite || options_.resume, "--resume");
  }

  // With --resume what was made from other poses is made anew; what no run of this command made is
  // a person's.
  void RefuseOthersOrthophotos(const OrthoPhotos& found) const {
    if (options_.overwrite) return;
    for (const ortho::OrientedPhoto& photo : found.photos)
      RefuseFileOfOthers(OrthoPath(photo.name),
                         [](const BandRaster& file) { return !file.Metadata(kMadeFrom).empty(); });
    if (options_.mosaic)  // old ones do not say what they were made from
      RefuseFileOfOthers(PathOf(kMosaic), [](const BandRaster& file) {
        return file.Metadata(kSoftware).starts_with("orient ");
      });
  }

  void TellPlan(const OrthoPhotos& found, double gsd_m, std::ostream& out) const {
    for (std::size_t i = 0; i < found.photos.size(); ++i) {
      const ortho::OrthoOptions options = OptionsFor(found, i, gsd_m);
      const std::string path = OrthoPath(found.photos[i].name);
      try {
        const ortho::MapGrid grid = ortho::PlanOrthophoto(found.photos[i], options).grid;
        out << block::PlanLine(IsCurrent(path, options),
                               fmt::format("ortho     {}: {} x {} px of {:g} m", path, grid.width,
                                           grid.height, gsd_m))
            << "\n";
      } catch (const InputError& error) {
        out << "cannot    " << found.photos[i].name << ": " << error.what() << "\n";
      }
    }
    if (!options_.mosaic) return;
    const std::string given = GivenSeams();
    if (!given.empty()) ortho::Seamlines::FromFile(given, found.crs);  // or it cannot be read
    out << block::PlanLine(!given.empty(), "seams     " + (given.empty() ? SeamsPath() : given))
        << "\n";
    out << block::PlanLine(false, "mosaic    " + PathOf(kMosaic)) << "\n";
  }

  double NaturalGsd(const OrthoPhotos& found) const {
    std::vector<double> sizes;
    for (const ortho::OrientedPhoto& photo : found.photos) {
      try {
        sizes.push_back(ortho::NaturalGsd(
            photo.view, ortho::SurfaceUnderPhoto(photo.view, options_.source.dem, found.crs)));
      } catch (const InputError&) {  // beside the DEM: that photo fails, unless all do
        if (&photo == &found.photos.back() && sizes.empty()) throw;
      }
    }
    // Rounded as written, in no locale's way.
    return NumberIn(fmt::format("{:.2g}", Median(sizes))).value();
  }

  ortho::OrthoOptions OptionsFor(const OrthoPhotos& found, std::size_t i, double gsd_m) const {
    constexpr double kFilmBorder = 0.01;  // of the frame: numbers, the shadow of its edge
    const Camera& camera = found.photos[i].view.camera;
    const bool film = camera.kind == CameraKind::kFilm;
    ortho::OrthoOptions options{
        options_.source.dem,
        found.crs,
        gsd_m,
        options_.dem_sigma_m,
        options_.border_mm.value_or(film ? kFilmBorder * camera.frame_mm.minCoeff() : 0),
        options_.jobs,
        Metadata()};
    options.metadata[kMadeFrom] =
        fmt::format("{}, pixel {:.9g} m, border {:.9g} mm, heights {:.9g} m", found.made_from[i],
                    gsd_m, options.border_mm, options_.dem_sigma_m);
    return options;
  }

  static std::map<std::string, std::string> Metadata() {
    return {{kSoftware, "orient " + ProgramVersion()}};
  }

  ortho::MosaicPart MakeOne(const OrthoPhotos& found, std::size_t i, double gsd_m,
                            std::ostream& out) {
    const ortho::OrientedPhoto& photo = found.photos[i];
    const ortho::OrthoOptions options = OptionsFor(found, i, gsd_m);
    const ortho::OrthoPlan plan = ortho::PlanOrthophoto(photo, options);
    const std::string path = OrthoPath(photo.name);
    const Eigen::Vector2d nadir = photo.view.pose.position_m.head<2>();
    std::string hidden = "kept";
    if (!IsCurrent(path, options)) {
      ShownProgress progress;
      const ortho::OrthoShares shares =
          ortho::MakeOrthophoto(photo, options, plan, path, &progress);
      any_made_ = true;
      hidden = fmt::format("{:.2f} % hidden", 100 * shares.hidden);
    }
    sources_[photo.name] = options.metadata.at(kMadeFrom);
    seam_photos_.push_back({photo.name, nadir, plan.outline_m});
    if (plan.accuracy) accuracies_.push_back(*plan.accuracy);
    if (plan.with_heights < kWholeFrame) cut_off_.emplace_back(plan.with_heights, photo.name);
    out << fmt::format("{}: {} x {} px of {:g} m, {}", path, plan.grid.width, plan.grid.height,
                       gsd_m, hidden);
    if (plan.accuracy)
      out << fmt::format(", CE90 {:.2g} m (worst {:.2g} m)", plan.accuracy->median_m,
                         plan.accuracy->worst_m);
    out << "\n";
    return {photo.name, path, plan.grid, nadir};
  }

  bool IsCurrent(const std::string& path, const ortho::OrthoOptions& options) const {
    if (!options_.resume || !fs::exists(path)) return false;
    try {
      const BandRaster made = BandRaster::Open(path);
      if (made.Metadata(kMadeFrom) != options.metadata.at(kMadeFrom) || !made.IsWhole())
        return false;
      const std::string hidden = ortho::HiddenPath(path);
      return made.Metadata(ortho::kHasHidden) != "yes" ||
             (fs::exists(hidden) && BandRaster::Open(hidden).IsWhole());
    } catch (const InputError&) {  // damaged
      return false;
    }
  }

  // Existing seamlines may have been edited.
  std::string GivenSeams() const {
    const bool kept = options_.seams.empty() && options_.resume && fs::exists(SeamsPath());
    return kept ? SeamsPath() : options_.seams;
  }

  void TellGivenSeams(const std::string& path, std::ostream& out) const {
    const std::vector<std::string>& named = seamlines_->Photos();
    out << path << ": " << named.size() << " polygons" << (options_.seams.empty() ? ", kept" : "")
        << "\n";
    for (const ortho::SeamPhoto& photo : seam_photos_)
      if (std::find(named.begin(), named.end(), photo.name) == named.end())
        out << "note      " << path << " has no polygon of " << photo.name
            << ", which only fills gaps\n";
  }

  std::map<std::string, std::string> MetadataOfSeams() const {
    const RunRecord record{"orient " + ProgramVersion(), "", "", 0, options_.inputs};
    return {{"orient_ortho", ProgramAndInputs(record)},
            {"orient_seamlines", options_.least_difference ? "least difference" : "nearest nadir"}};
  }

  ortho::Seamlines DrawSeams(const OrthoPhotos& found,
                             const std::vector<ortho::PhotoCells>& cells) const {
    auto seamlines = options_.least_difference
                         ? ortho::SeamlinesOfLeastDifference(seam_photos_, cells)
                         : ortho::Seamlines::ByNearestNadir(seam_photos_);
    seamlines.Write(SeamsPath(), found.crs, MetadataOfSeams());
    return seamlines;
  }

  // Applies the balanced tones to the parts and their cells.
  void Balance(std::vector<ortho::PhotoCells>* cells, std::vector<ortho::MosaicPart>* parts,
               std::ostream& out) const {
    ortho::BalancedTones balanced = ortho::BalanceTones(*cells);
    ortho::ShowInTones(balanced.tones, cells);
    std::string table = "photo,band,gain,offset\n";
    for (std::size_t i = 0; i < parts->size(); ++i) {
      (*parts)[i].tones = std::move(balanced.tones[i]);
      int band = 0;
      for (const ortho::Tone& tone : (*parts)[i].tones)
        table += fmt::format("{},{},{:.6g},{:.6g}\n", CsvCell((*parts)[i].name), ++band, tone.gain,
                             tone.offset);
    }
    WriteFileAtomically(TonesPath(), table);
    if (balanced.would_worsen)
      out << fmt::format(
          "note      balancing would bring overlapping photos no closer than the {:.3g} grey "
          "values by which they differ: they keep their own tones\n",
          *balanced.before);
    else if (balanced.before)
      out << fmt::format(
          "{}: overlapping photos differ by {:.3g} grey values in the mean, {:.3g} "
          "before\n",
          TonesPath(), *balanced.after, *balanced.before);
    for (const int photo : balanced.alone)
      out << "note      " << (*parts)[static_cast<std::size_t>(photo)].name
          << " overlaps no other photo and keeps its own tone\n";
    for (const int photo : balanced.bounded)
      out << "note      " << (*parts)[static_cast<std::size_t>(photo)].name
          << " differs so much from its neighbours in contrast that its gain is bounded\n";
  }

  // CE90 only if it is known of all photos.
  std::map<std::string, std::string> MetadataOfMosaic(
      const std::vector<ortho::MosaicPart>& parts) const {
    std::map<std::string, std::string> metadata = Metadata();
    std::string names;
    for (const ortho::MosaicPart& part : parts) names += (names.empty() ? "" : ", ") + part.name;
    metadata["ORIENT_PHOTOS"] = names;
    metadata[kMadeFrom] = TextOfSources(sources_);
    metadata["ORIENT_DEM"] = fs::path(options_.source.dem).filename().string();
    if (accuracies_.size() < parts.size()) return metadata;
    std::vector<double> medians;
    double worst_m = 0;
    for (const GroundAccuracy& accuracy : accuracies_) {
      medians.push_back(accuracy.median_m);
      worst_m = std::max(worst_m, accuracy.worst_m);
    }
    metadata["ORIENT_CE90_MEDIAN_M"] = fmt::format("{:.4g}", Median(medians));
    metadata["ORIENT_CE90_WORST_M"] = fmt::format("{:.4g}", worst_m);
    return metadata;
  }

  // A table of tones that the mosaic does not show would be wrong.
  void RemoveTones(std::ostream& out) const {
    if (options_.balance || !fs::remove(TonesPath())) return;
    out << "note      the mosaic was balanced before, and is not without --balance; " << TonesPath()
        << " is removed\n";
  }

  void MakeMosaic(const OrthoPhotos& found, std::vector<ortho::MosaicPart> parts,
                  std::ostream& out) {
    ShownProgress progress;
    const std::string given = GivenSeams();
    std::vector<ortho::PhotoCells> cells;
    if (options_.balance || (options_.least_difference && given.empty()))
      cells = ortho::ReadCells(parts, options_.jobs, &progress);
    if (options_.balance) Balance(&cells, &parts, out);
    if (options_.least_difference && given.empty())
      out << fmt::format("{}: sought in cells of {:g} m\n", SeamsPath(), cells.front().grid.gsd_m);
    if (options_.least_difference && !given.empty())
      out << "note      " << given
          << " exists and is kept; --overwrite, or removing the file, gives new seamlines\n";
    if (seamlines_)
      TellGivenSeams(given, out);
    else
      seamlines_ = DrawSeams(found, cells);
    cells.clear();
    const std::string path = PathOf(kMosaic);
    const ortho::MapGrid grid = ortho::MakeMosaic(
        parts, *seamlines_, found.crs, MetadataOfMosaic(parts), options_.jobs, path, &progress);
    RemoveTones(out);
    out << fmt::format("{}: {} x {} px of {:g} m from {} photos\n", path, grid.width, grid.height,
                       grid.gsd_m, parts.size());
  }

  // Orthophotos that end with the DEM, those first that show least.
  void TellDemsEnd(std::ostream& out) const {
    auto cut_off = cut_off_;
    std::sort(cut_off.begin(), cut_off.end());
    std::vector<std::string> shares;
    for (const auto& [share, photo] : cut_off)
      shares.push_back(fmt::format("{} ({:.0f} %)", photo, 100 * share));
    if (!shares.empty())
      out << fmt::format(
          "note      {} ends or has no heights under part of the frame of {} photo{}, whose "
          "orthophoto{} only the rest: {}\n",
          options_.source.dem, shares.size(), shares.size() == 1 ? "" : "s",
          shares.size() == 1 ? " shows" : "s show", block::Listed(shares));
  }

  // A mosaic of an earlier run that does not show what is in the folder now.
  void TellOldMosaic(std::ostream& out) const {
    const std::string path = PathOf(kMosaic);
    if (!fs::exists(path)) return;
    const OrthoFolder folder = ReadOrthophotosIn(options_.out);
    if (!folder.mosaic) return;  // damaged
    const MosaicChanges& changes = folder.mosaic->changes;
    std::string what;
    if (!changes.others.empty())
      what = "was made from other orthophotos of " + block::Listed(changes.others);
    if (!changes.lacking.empty())
      what += (what.empty() ? "was made without the orthophotos of "
                            : ", and was made without those of ") +
              block::Listed(changes.lacking);
    if (!folder.mosaic->says_sources && any_made_)
      what = "was there before these orthophotos, and does not say what it was made from";
    if (!what.empty()) out << "note      " << path << " " << what << "; --mosaic makes it anew\n";
  }

  const OrthoRunOptions& options_;
  std::vector<ortho::SeamPhoto> seam_photos_;
  std::optional<ortho::Seamlines> seamlines_;            // the given ones, later those drawn
  std::vector<GroundAccuracy> accuracies_;               // of photos whose poses have a covariance
  std::vector<std::pair<double, std::string>> cut_off_;  // share of the frame with heights; photo
  MosaicSources sources_;
  bool any_made_ = false;  // an orthophoto: not all were kept from earlier runs
};

}  // namespace

std::vector<std::string> OrthophotoFiles(const std::string& folder,
                                         const std::vector<std::string>& photos) {
  std::vector<std::string> files;
  for (const std::string& photo : photos)
    files.push_back((fs::path(folder) / (photo + kOrtho)).string());
  for (const char* file : {kMosaic, kSeams, kTones})
    files.push_back((fs::path(folder) / file).string());
  return files;
}

bool MakeOrthophotos(const OrthoRunOptions& options, std::ostream& out) {
  return OrthoRun(options).Do(out);
}

}  // namespace orient
