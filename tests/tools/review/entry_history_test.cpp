#include "tools/review/entry_history.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// Few letters, so that beginnings and ends are alike; any of three files.
rc::Gen<FileTexts> AnyFiles() {
  const auto text =
      rc::gen::maybe(rc::gen::container<std::string>(rc::gen::element('a', 'b', '\n')));
  return rc::gen::map(rc::gen::tuple(text, text, text), [](const auto& texts) {
    FileTexts files;
    if (const auto& marks = std::get<0>(texts)) files["marks.csv"] = *marks;
    if (const auto& points = std::get<1>(texts)) files["points.csv"] = *points;
    if (const auto& decisions = std::get<2>(texts)) files["decisions.csv"] = *decisions;
    return files;
  });
}

// A word writes files and takes none away.
FileTexts After(FileTexts before, const FileTexts& written) {
  for (const auto& [file, text] : written) before[file] = text;
  return before;
}

RC_GTEST_PROP(EntryHistory, LeadsBackThroughAllWordsAlsoWhereItIsReadAgain, ()) {
  const TemporaryFolder folder;
  const std::string path = folder / "undo.json";
  std::vector<FileTexts> states = {*AnyFiles()};
  const auto entries = *rc::gen::resize(10, rc::gen::container<std::vector<FileTexts>>(AnyFiles()));
  {
    EntryHistory history(path, states.front());
    for (const FileTexts& written : entries) {
      states.push_back(After(states.back(), written));
      history.Add("word", states[states.size() - 2], states.back());
    }
  }
  for (; states.size() > 1; states.pop_back()) {
    EntryHistory history(path, states.back());
    RC_ASSERT(history.LeadsTo(states.back()));
    RC_ASSERT(history.BeforeLatest(states.back()) == states[states.size() - 2]);
    history.ForgetLatest();
  }
  RC_ASSERT(EntryHistory(path, states.back()).IsEmpty());
}

TEST(EntryHistory, OfAReviewThatEndedBetweenUndoingAndForgettingLeadsToTheWordBefore) {
  const TemporaryFolder folder;
  const FileTexts none, one = {{"marks.csv", "1"}}, two = {{"marks.csv", "2"}};
  {
    EntryHistory history(folder / "undo.json", none);
    history.Add("first", none, one);
    history.Add("second", one, two);
  }
  EXPECT_EQ(EntryHistory(folder / "undo.json", one).LatestAbout(), "first");
  EXPECT_EQ(EntryHistory(folder / "undo.json", two).LatestAbout(), "second");
  EXPECT_TRUE(EntryHistory(folder / "undo.json", {{"marks.csv", "3"}}).IsEmpty());
}

// "Ä" and "Ö" begin with the same byte.
TEST(EntryHistory, CutsNoCharacter) {
  const TemporaryFolder folder;
  const FileTexts before = {{"points.csv", "\u00c41,5\n\u00d61,6\n"}},
                  after = {{"points.csv", "\u00d61,6\n"}};
  {
    EntryHistory history(folder / "undo.json", before);
    history.Add("withdrawal", before, after);
  }
  EntryHistory history(folder / "undo.json", after);
  ASSERT_TRUE(history.LeadsTo(after));
  EXPECT_EQ(history.BeforeLatest(after), before);
}

TEST(EntryHistory, OfAnotherMakerIsForgotten) {
  const TemporaryFolder folder;
  const FileTexts now = {{"marks.csv", "1"}};
  WriteFileAtomically(folder / "undo.json",
                      R"({"entries": [{"about": "a", "version_after": ")" + VersionOf(now) +
                          R"(", "before": {"marks.csv": {"begin": 0, "end": 9, "middle": ""}}}]})");
  EXPECT_TRUE(EntryHistory(folder / "undo.json", now).IsEmpty());
}

TEST(EntryHistory, ThatCannotBeWrittenLivesOn) {
  const TemporaryFolder folder;
  EntryHistory history(folder / "no/such/folder/undo.json", {});
  history.Add("word", {}, {{"marks.csv", "1"}});
  EXPECT_EQ(history.LatestAbout(), "word");
  EXPECT_TRUE(history.BeforeLatest({{"marks.csv", "1"}}).empty());
}

}  // namespace
}  // namespace orient
