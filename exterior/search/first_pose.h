// The first rounds of the loop: from the approximation to a pose that chance does not explain, at
// coarse resolution. Private to exterior.
#pragma once

#include <optional>
#include <string>

#include "exterior/search/whole_photo_search.h"
#include "exterior/steps/photo_task.h"

namespace orient::exterior {

// From the prior to a first pose; the caller asks whether chance explains it. Empty: see
// WhyNoFirstPose. The effort is limited by pixels searched, not by time, so that it ends the same
// way on every machine.
std::optional<PoseTrack> FirstPose(const PhotoTask& task);

// The same from the prior as it stands, where a few patches at the coarsest resolution and in
// windows of moderate size are enough to show what chance does not explain; empty otherwise.
std::optional<PoseTrack> EasyFirstPose(const PhotoTask& task);

// Where kappa is open and the position is not: first poses in sectors of kappa, with windows of
// moderate size, a few patches in all sectors before more. Every kappa if the search within the
// stated accuracy has failed before, else those that the accuracy allows. `trials`: in how many
// ways a first pose is searched for, these (KappaTrials at most) and others together.
WholePhotoSearch FirstPoseByKappa(const PhotoTask& task, double trials);
double KappaTrials(const PhotoTask& task);

// What is wrong with the approximation or the patches, where there is no first pose.
Finding WhyNoFirstPose(const PhotoTask& task);

// The pose that the patches around a rough one agree on; empty where too few do.
std::optional<PoseTrack> Confirmed(const PhotoTask& task, const PoseTrack& rough);

// Halves the reduction while it stays above full resolution and is no finer than `finest`.
void Descend(const PhotoTask& task, int finest, PoseTrack* track);

}  // namespace orient::exterior
