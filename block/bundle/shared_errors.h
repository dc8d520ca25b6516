// What errors that control patches share, and that no residual shows, add to the poses' covariances
// of a block: see unseen_errors.h. Private to block.
#pragma once

#include "block/bundle/normal_equations.h"

namespace orient::block {

// Effect of such errors on all unknowns, a column per draw, so that its product with its transpose
// is a covariance; empty if control shares no errors.
Eigen::MatrixXd UnknownsMovedByControl(const BlockSystem& system, const BlockNormals& normals,
                                       const BlockTests& tests);

// The adjustment's unknowns are linear in the control; random fields of such errors are propagated
// through it as it is (BlockOptions::control_shared_*), and what they do on average to poses, to
// poses together, to the parameters of cameras and GNSS and to tie points is added to their
// covariances. The same fields every time. Needs FillOutcome's result. Covariances of control's own
// adjusted ground stay without: they say how control fits.
void AddSharedControlErrors(const BlockSystem& system, const BlockNormals& normals,
                            const BlockTests& tests, BlockResult* result);

}  // namespace orient::block
