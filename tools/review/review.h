// `orient review` without its network: what each request is answered.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/embedded_file.h"
#include "core/base/folder_lock.h"
#include "core/terrain/ground_surface.h"
#include "tools/review/measurement_folder.h"
#include "tools/review/review_json.h"
#include "tools/review/review_state.h"
#include "tools/review/run_again.h"
#include "tools/review/scan_tiles.h"
#include "tools/review/seen_mark.h"

namespace orient {

struct ReviewOptions {
  std::string directory;           // OUT
  std::vector<std::string> scans;  // paths
  std::string measurements;        // folder
  std::string by;                  // who says it
  std::string ortho;               // under the map; empty: none
  std::string dem;                 // heights of points clicked in the map; empty: none
  std::string camera;              // whose marks and frame are expected; empty: not known
  ScanKnowledge scan;              // as the run was told
  RunAgain::Run run_again;         // empty: not offered,
  std::string why_not_again = {};  // for this reason
};

struct Reply {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body;
  bool keep = false;  // whether the browser may take it from its cache
};

// A path below the token, cut at its slashes and decoded: {"api", "photo", "4711"}.
using WebPath = std::vector<std::string>;

// Safe from several threads.
class Review {
 public:
  // Throws InputError where the folder holds no results, another review is open on it, the
  // measurements are wrong, the viewer's files (Debian's libjs-leaflet) are not there, or the
  // orthophoto does not lie in the block's CRS; UsageError where two scans have one name.
  explicit Review(ReviewOptions options);

  // What goes wrong in answering is the answer.
  Reply Get(const WebPath& path, const std::map<std::string, std::string>& query);
  Reply Post(const WebPath& path, const std::string& body);

 private:
  Reply GetData(const WebPath& path, const std::map<std::string, std::string>& query);
  Reply GetPhoto(const std::string& name);
  ScanKnowledge KnownOf(const PhotoRecord& photo) const;
  Reply GetSeen(const std::map<std::string, std::string>& query);
  Reply GetHeight(const std::map<std::string, std::string>& query);
  Reply GetProgress() const;
  Reply GetTile(ScanTiles* tiles, const std::string& scan, const WebPath& place);
  Reply Record(const std::string& body);
  Reply Undo(const std::string& body);
  Reply Start();
  void ReadViewer();
  void ReadOrtho();
  void RequireValid(const Entry& entry);
  void RequireMark(const PhotoRecord& photo, const MarkMeasurement& mark);

  ReviewOptions options_;
  FolderLock lock_;  // two would orient again at the same time
  ReviewStates states_;
  MeasurementFolder folder_;
  ScanTiles scans_, ortho_;
  std::optional<MapGround> ground_;
  std::optional<CameraFile> camera_;
  std::mutex surface_mutex_;
  std::optional<GroundSurface> surface_;
  std::map<std::string, Reply> files_;  // of page and viewer
  RunAgain run_again_;
};

// The page's own files (data/review); made by orient_embed().
std::span<const EmbeddedFile> ReviewFiles();

}  // namespace orient
