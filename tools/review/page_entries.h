// What the page says, as JSON:
//   {"version": "...", "about": "mark 3 of photo 4711",
//    "marks": [{"photo": "4711", "mark": "3", "pixel": [12.5, 80.5], "sigma": 1, "exact": false}],
//    "image_points": [{"photo": "4711", "point": "p1", "pixel": [300.5, 20.5], "sigma": 1}],
//    "points": [{"point": "p1", "ground": [x, y, z], "sigma": [sx, sy, sz], "role": "control"}],
//    "decisions": [{"photo": "4711", "decision": "accept", "value": "", "reason": "seen"}],
//    "no_marks": [["4711", "3"]], "no_image_points": [["4711", "p1"]],
//    "no_points": ["p1"], "no_decisions": [["4711", "accept"]]}
// All but the version may be absent.
#pragma once

#include <string>

#include "tools/review/measurement_folder.h"

namespace orient {

struct PageEntry {
  std::string version;  // of what was attribution, as the page had read it
  Entry entry;
};

// `attribution`: who says it and when. Throws InputError naming what is wrong in the text.
PageEntry EntryOfPage(const std::string& text, const Attribution& attribution);

// Photos that are named in it, each once.
std::vector<std::string> PhotosOf(const Entry& entry);

}  // namespace orient
