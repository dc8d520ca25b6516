// Which of several readings of one scan is the most probable, and how far ahead of the others.
#pragma once

#include <vector>

#include "interior/film_search.h"

namespace orient {

// Two readings say the same when every mark that both found lies in one place; with fewer than two
// such marks, when their transforms agree. One that found nothing says nothing else.
bool SaysTheSame(const FilmReading& a, const FilmReading& b);

// The most probable reading; its margins are those to all the others. `readings` is not empty.
FilmReading BestOf(const std::vector<FilmReading>& readings);

}  // namespace orient
