// Reading the elements of a mark drawing. Private to core/files, as toml_fields.h.
#pragma once

#include "core/files/mark_elements.h"
#include "core/files/toml_fields.h"

namespace orient {

// `raw` stands at `name` in `file`. Throws InputError as TomlTable does: unknown shapes and keys,
// impossible sizes.
MarkElement ReadMarkElement(const toml::table& raw, const std::string& file,
                            const std::string& name);

}  // namespace orient
