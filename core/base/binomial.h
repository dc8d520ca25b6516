// Confidence bounds of rates.
#pragma once

namespace orient {

// The rate under which `found` or fewer of `tried` would be seen with this probability only: exact
// upper confidence bound (Clopper & Pearson 1934). 1 where nothing was tried.
double UpperBoundOfRate(int found, int tried, double probability);

}  // namespace orient
