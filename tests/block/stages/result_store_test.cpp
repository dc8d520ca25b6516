#include "block/stages/result_store.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "tests/block/stages/fake_stage.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

const Inputs kInputs = {{"camera", "a"}, {"scan", "b"}};

class ResultStoreTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  ResultStore store_{folder_.Path(), ".exterior.json"};
};

TEST_F(ResultStoreTest, KnowsWhatIsAbsentCurrentAndChanged) {
  EXPECT_EQ(store_.Check("p", kInputs).state, ResultState::kAbsent);
  WriteFakeResult(store_, "p", kInputs);
  EXPECT_EQ(store_.Check("p", kInputs).state, ResultState::kCurrent);
  EXPECT_TRUE(store_.IsCurrent("p", kInputs));
  EXPECT_EQ(store_.MadeFrom("p"), kInputs);
  const KnownResult known = store_.Check("p", {{"camera", "a"}, {"scan", "c"}, {"dem", "d"}});
  EXPECT_EQ(known.state, ResultState::kChanged);
  EXPECT_EQ(known.changed, (std::vector<std::string>{"dem", "scan"}));
  store_.Drop("p");
  EXPECT_EQ(store_.Check("p", kInputs).state, ResultState::kAbsent);
  store_.Drop("p");
}

TEST_F(ResultStoreTest, AResultThatDoesNotSayWhatItWasMadeFromIsAStateOfItsOwn) {
  WriteFileAtomically(store_.PathOf("p"), "{\"photo\": \"p\"}");
  EXPECT_EQ(store_.Check("p", kInputs).state, ResultState::kUnstated);
}

TEST_F(ResultStoreTest, ADamagedResultIsUnreadable) {
  for (const char* text : {"", "{", "{\"made_from\": \"0123456789abcdef\"}"}) {
    WriteFileAtomically(store_.PathOf("p"), text);
    EXPECT_EQ(store_.Check("p", kInputs).state, ResultState::kUnreadable) << text;
    EXPECT_FALSE(store_.MadeFrom("p")) << text;
  }
  std::filesystem::create_directory(store_.PathOf("q"));
  EXPECT_EQ(store_.Check("q", kInputs).state, ResultState::kUnreadable);
}

TEST_F(ResultStoreTest, ListsItsOwnJobsOnly) {
  for (const char* name : {"b", "a.b"}) WriteFakeResult(store_, name, kInputs);
  WriteFakeResult(ResultStore(folder_.Path(), ".ties.json"), "c", kInputs);
  EXPECT_EQ(store_.Jobs(), (std::vector<std::string>{"a.b", "b"}));
  EXPECT_TRUE(ResultStore(folder_ / "absent", ".json").Jobs().empty());
}

}  // namespace
}  // namespace orient::block
