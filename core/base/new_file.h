// A file that appears whole or not at all, whoever writes it: every file of the program is made
// through this.
#pragma once

#include <string>
#include <string_view>

#include "core/base/gdal_faults.h"

namespace orient {

class NewFile {
 public:
  // Makes <target>.<process>-<n>.part beside the target, a file that was not there: no link of that
  // name is followed. Throws InputError naming target and cause (a read-only folder),
  // EnvironmentError where there is no space or the device fails.
  explicit NewFile(std::string target);
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile();  // removes it unless it was kept

  // Until it is kept: for libraries that write files by name.
  const std::string& PartialPath() const { return partial_; }
  void Write(std::string_view contents);
  // Flushes it to disk, gives it its name in place of what had it, flushes the folder.
  void Keep();
  // The same where nothing has the name; otherwise throws InputError and leaves what is there.
  void KeepAsNew();
  // After a library failed to write it: EnvironmentError where the machine refused that to GDAL,
  // else InputError naming target and `why`.
  [[noreturn]] void Fail(const std::string& why) const;

 private:
  void Flush();

  std::string target_;
  std::string partial_;
  int descriptor_ = -1;
  bool kept_ = false;
  GdalFaults faults_;  // of what GDAL writes to it, on the thread that made it
};

}  // namespace orient
