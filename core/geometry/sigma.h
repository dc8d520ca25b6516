// What a measurement's standard deviation may be.
#pragma once

#include <string>

namespace orient {

// Why this can be none, in pixels, mm, m or degrees; empty where it can. With larger and smaller
// ones weights are no finite numbers any more.
std::string WhyNoSigma(double sigma);

}  // namespace orient
