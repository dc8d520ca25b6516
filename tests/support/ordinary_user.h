// Permissions of an ordinary user, for tests of write protection: root may write everywhere.
#pragma once

#include <unistd.h>

#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace orient {

// During its lifetime, a root process has the permissions of "nobody", who owns `folder` and all in
// it. Does nothing for other users.
class OrdinaryUser {
 public:
  explicit OrdinaryUser(const std::string& folder) {
    if (geteuid() != 0) return;
    Own(folder);
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      Own(entry.path());
    if (setegid(kNobody) != 0 || seteuid(kNobody) != 0)
      throw std::runtime_error("root cannot become nobody");
    was_root_ = true;
  }
  ~OrdinaryUser() {
    if (was_root_ && (seteuid(0) != 0 || setegid(0) != 0)) std::terminate();
  }
  OrdinaryUser(const OrdinaryUser&) = delete;
  OrdinaryUser& operator=(const OrdinaryUser&) = delete;

 private:
  static constexpr uid_t kNobody = 65534;

  static void Own(const std::string& path) {
    if (chown(path.c_str(), kNobody, kNobody) != 0)
      throw std::runtime_error("cannot give away " + path);
  }

  bool was_root_ = false;
};

}  // namespace orient
