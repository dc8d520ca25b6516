// What errors that control patches share, and that no residual shows, add to the poses' covariances
// of a block: see unseen_errors.h. Private to exterior.
#pragma once

#include "exterior/block_normals.h"

namespace orient {

// The adjustment's poses are linear in the control; random fields of such errors are propagated
// through it as it is (BlockOptions::control_shared_*), and the mean square of what they do to each
// pose is added to its covariance. The same fields every time. Needs FillOutcome's result. What
// they do to a calibration, to tie points and to the poses' covariances among themselves is not in
// it.
void AddSharedControlErrors(const BlockSystem& system, const BlockNormals& normals,
                            const BlockTests& tests, BlockResult* result);

}  // namespace orient
