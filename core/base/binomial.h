// Confidence bounds of rates, and how probable it is that many events happen together.
#pragma once

#include <vector>

namespace orient {

// The rate at which `found` or fewer out of `tried` would occur with only this probability: exact
// upper confidence bound (Clopper & Pearson 1934). 1 if nothing was tried.
double UpperBoundOfRate(int found, int tried, double probability);

// Upper bound (Chernoff 1952) of the natural logarithm of the probability that `count` or more of
// independent events happen, each with its own probability; 0 where as many are expected.
double LogTailBound(const std::vector<double>& probabilities, double count);

}  // namespace orient
