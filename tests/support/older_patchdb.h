// Patch databases as written by earlier versions of the program.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <string>

namespace orient {

// Converts a current file to its form before the content token (schema version 4).
inline void MakeVersion3(const std::string& path) {
  SQLite::Database(path, SQLite::OPEN_READWRITE)
      .exec(
          "DROP TRIGGER orient_content_insert; DROP TRIGGER orient_content_delete;"
          "DROP TRIGGER orient_content_update; DROP TRIGGER orient_content_state;"
          "DROP TABLE orient_content; DELETE FROM orient_schema WHERE version > 3;"
          "DELETE FROM gpkg_contents WHERE table_name = 'orient_content'");
}

}  // namespace orient
