// Which of several readings of one scan is the most probable, and how far ahead of the others.
#pragma once

#include <vector>

#include "interior/constellation/film_reading.h"

namespace orient::interior {

// Two readings agree if every mark that both found lies in the same place; where these marks do
// not span an area, so that they leave open the scan orientation, their transforms must agree over
// the whole frame as well. One that found nothing contradicts none. Of two scan orientations that
// only pictures of the marks tell apart, the marks' places alone count, not their names.
bool ReadingsAgree(const FilmReading& a, const FilmReading& b);

// Whether these marks of another reading are a film of their own: enough to be accepted, not much
// less probable than the best reading's, beside these, and none of them where these have one. Two
// films on one scan do not exclude each other, so that it means nothing which of them is a few nats
// more probable.
bool ShowsAnotherFilm(const FilmReading& best, const FilmReading& other, const Assignment& marks);

// The most probable reading; its margins are those to all the others, and none where the scan shows
// another film. `readings` is not empty. `excluded`: those in the polarity that the user excluded;
// they are no rivals, but those of enough marks set the polarity margin, unless they are another
// film.
FilmReading BestOf(const std::vector<FilmReading>& readings,
                   const std::vector<FilmReading>& excluded = {});

}  // namespace orient::interior
