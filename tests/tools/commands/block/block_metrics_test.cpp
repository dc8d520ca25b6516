#include "tools/commands/block/block_metrics.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

TEST(BlockMetrics, ReplaceMetricsAndNothingElse) {
  const TemporaryFolder folder;
  const std::string path = folder / "orient.prom", other = folder / "block.toml";
  WriteMetrics(path, {}, false);
  WriteMetrics(path, {}, true);
  EXPECT_EQ(ReadFile(path), MetricsText({}, true));
  WriteFileAtomically(other, "crs = \"EPSG:32635\"\n");
  ExpectError<UsageError>([&] { WriteMetrics(other, {}, true); }, {other, "no metrics of orient"});
  EXPECT_EQ(ReadFile(other), "crs = \"EPSG:32635\"\n");
}

TEST(BlockMetrics, SayWhatTheStatusSays) {
  block::StageStatus interior, exterior;
  interior.stage = block::BlockStage::kInterior;
  exterior.stage = block::BlockStage::kExterior;
  interior.photos = exterior.photos = 10;
  interior.ok = 10;
  exterior.ok = 4;
  exterior.weak = 2;
  exterior.failed = 1;
  exterior.per_hour = 1234.56;
  EXPECT_EQ(MetricsText({interior, exterior}, false),
            "# HELP orient_photos Photos of the block, by stage and state.\n"
            "# TYPE orient_photos gauge\n"
            "orient_photos{stage=\"interior\",state=\"ok\"} 10\n"
            "orient_photos{stage=\"interior\",state=\"weak\"} 0\n"
            "orient_photos{stage=\"interior\",state=\"failed\"} 0\n"
            "orient_photos{stage=\"interior\",state=\"unreadable\"} 0\n"
            "orient_photos{stage=\"interior\",state=\"left\"} 0\n"
            "orient_photos{stage=\"exterior\",state=\"ok\"} 4\n"
            "orient_photos{stage=\"exterior\",state=\"weak\"} 2\n"
            "orient_photos{stage=\"exterior\",state=\"failed\"} 1\n"
            "orient_photos{stage=\"exterior\",state=\"unreadable\"} 0\n"
            "orient_photos{stage=\"exterior\",state=\"left\"} 3\n"
            "# HELP orient_photos_per_hour Results of the last hour, all machines together.\n"
            "# TYPE orient_photos_per_hour gauge\n"
            "orient_photos_per_hour{stage=\"exterior\"} 1234.6\n"
            "# HELP orient_block_finished Whether all outputs of the block are written.\n"
            "# TYPE orient_block_finished gauge\n"
            "orient_block_finished 0\n");
}

}  // namespace
}  // namespace orient
