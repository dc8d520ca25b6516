// What the machine refuses to SQLite when GDAL reads a database (GeoPackage): SQLite calls a
// failing device a malformed database, and GDAL what it cannot read absent. Internal to
// core/base.
#pragma once

namespace orient {

// `note` is given what could not be done ("open", "read"), to which file, and errno, from now on
// and for all databases of the process, on the thread that asked for it.
void WatchSqliteFiles(void (*note)(const char* doing, const char* path, int error));

}  // namespace orient
