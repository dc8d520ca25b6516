// The camera library: nominal camera files that come with the program (data/cameras).
//
// A camera in the library's subfolder format_only has marks where the film's format puts them and
// no calibration report behind them: it can be named, and is never a guess of --camera auto.
#pragma once

#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {

struct LibraryCamera {
  std::string name;  // the file's name without its ending
  std::string path;
  bool format_only = false;
  CameraFile file;
  interior::MarkShapes shapes;
};

// The folder of the library: `option` where it is given, else $ORIENT_CAMERAS, else
// share/orient/cameras beside the program's own folder, else the source tree's data/cameras. Throws
// InputError where there is none.
std::string CameraLibraryFolder(const std::string& option);

// Every camera of a library, by name. Throws InputError for an unreadable file and a folder without
// camera files.
std::vector<LibraryCamera> ReadCameraLibrary(const std::string& folder);

// A camera file's path as it is; for a name like wild_rc10 that is not a file, the path of the
// library's file. Throws InputError where neither is there, naming similar cameras.
std::string FindCameraFile(const std::string& path_or_name, const std::string& library_option);

}  // namespace orient::block
