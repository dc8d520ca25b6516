// What the results in a folder of `orient exterior` have in common: a resumed run keeps them, and
// says of all that they are true with its own camera.
#pragma once

#include <optional>
#include <string>

namespace orient {

struct ExteriorInputs {
  std::string camera, dem;  // digests
  std::string options;      // as text
  // To the camera file's lens, by the first run: more photos would change it.
  double added_earth_k1 = 0;
};

// <directory>/exterior_inputs.json
void WriteExteriorInputs(const std::string& directory, const ExteriorInputs& inputs);
// Empty where there is none. Throws InputError: damaged.
std::optional<ExteriorInputs> ReadExteriorInputs(const std::string& directory);

// Throws InputError naming what `now` has other than `then` (added_earth_k1 aside) and what to do.
void RequireSameInputs(const std::string& directory, const ExteriorInputs& then,
                       const ExteriorInputs& now);

}  // namespace orient
