// Outputs that must not take a database's place.
#pragma once

#include <string>
#include <vector>

namespace orient {

// Throws UsageError where one of these files is an SQLite database, which a mistyped command would
// otherwise replace by a table or picture; empty names are passed over. No option overrules it.
void RefuseToReplaceDatabase(const std::vector<std::string>& outputs);

}  // namespace orient
