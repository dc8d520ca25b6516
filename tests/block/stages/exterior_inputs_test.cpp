#include "block/stages/exterior_inputs.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

ExteriorResult Result(const std::string& photo, const Inputs& made_from) {
  ExteriorResult result;
  result.photo = photo;
  result.made_from = made_from;
  return result;
}

TEST(InputsOfPhoto, AreThoseOfItsRunAndItsOwn) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "p.tif", "a scan");
  ExteriorRunOptions options;
  options.inputs = {{"camera", "a"}};
  OrientationTable table;
  table.rows.push_back({"p", {{1, 2, 3}, {0, 0, 0}}, std::nullopt});
  const auto inputs = [&] { return InputsOfPhoto(options, table, folder / "p.tif"); };
  const Inputs then = inputs();
  EXPECT_EQ(inputs(), then);
  table.rows[0].pose.position_m.x() += 1e-9;
  EXPECT_EQ(WhatChanged(then, inputs()), std::vector<std::string>{"approximation"});
  table.rows[0].pose.position_m.x() = 1;
  options.position_sigma_m = 5;
  EXPECT_EQ(WhatChanged(then, inputs()), std::vector<std::string>{"accuracy"});
  options.position_sigma_m.reset();
  WriteFileAtomically(folder / "p.tif", "another scan");
  EXPECT_EQ(WhatChanged(then, inputs()), std::vector<std::string>{"scan"});
  options.interior = folder.Path();
  EXPECT_TRUE(inputs().contains("interior"));
  EXPECT_EQ(inputs().at("camera"), "a");
}

TEST(RequireSameInputs, NamesWhatAnyResultOfTheFolderWasMadeWith) {
  const TemporaryFolder folder;
  const ResultStore store = ExteriorStore(folder.Path());
  const Inputs run = {{"camera", "a"}, {"dem", "b"}, {"options", "earth auto"}};
  Inputs made_from = run;
  made_from["scan"] = "a photo's own is its own affair";
  WriteExteriorResult(folder.Path(), Result("p", made_from));
  WriteExteriorResult(folder.Path(), Result("says_nothing", {}));
  RequireSameInputs(store, store.Jobs(), run);
  made_from["dem"] = "another";
  made_from["options"] = "earth flat";
  WriteExteriorResult(folder.Path(), Result("q", made_from));
  try {
    RequireSameInputs(store, store.Jobs(), run);
    FAIL() << "nothing was refused";
  } catch (const InputError& error) {
    const std::string said = error.what();
    for (const char* word : {"that of q", "other inputs (DEM, options (earth flat; now earth auto)",
                             "--overwrite instead of --resume"})
      EXPECT_NE(said.find(word), std::string::npos) << said;
  }
}

TEST(OwnResultsFirst, AreThoseOfTheRunsPhotosWhereAnyIsThere) {
  const TemporaryFolder folder;
  const ResultStore store = ExteriorStore(folder.Path());
  WriteExteriorResult(folder.Path(), Result("p", {{"dem", "a"}}));
  WriteExteriorResult(folder.Path(), Result("q", {{"dem", "b"}}));
  EXPECT_EQ(OwnResultsFirst(store, {"scans/q.tif"}), std::vector<std::string>{"q"});
  EXPECT_EQ(OwnResultsFirst(store, {"scans/r.tif"}), (std::vector<std::string>{"p", "q"}));
}

TEST(EarthK1Of, IsThatOfAResultThatSaysIt) {
  const TemporaryFolder folder;
  const ResultStore store = ExteriorStore(folder.Path());
  EXPECT_FALSE(EarthK1Of(store, store.Jobs()));
  WriteFileAtomically(store.PathOf("a"), "damaged");
  WriteExteriorResult(folder.Path(), Result("b", {}));
  EXPECT_FALSE(EarthK1Of(store, store.Jobs()));
  ExteriorResult result = Result("c", {});
  result.earth_k1 = 0;  // over a flat one
  WriteExteriorResult(folder.Path(), result);
  EXPECT_EQ(EarthK1Of(store, store.Jobs()), 0);
}

}  // namespace
}  // namespace orient::block
