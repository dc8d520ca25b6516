#include "block/bundle/bundle_result.h"

namespace orient::block {

const char* Name(ObservationState state) {
  switch (state) {
    case ObservationState::kUsed:
      return "used";
    case ObservationState::kRejected:
      return "rejected";
    case ObservationState::kHeldOut:
      return "held out";
    case ObservationState::kAlone:
      return "alone";
    case ObservationState::kWeakAngle:
      return "weak angle";
    case ObservationState::kUnusable:
      break;
  }
  return "unusable";
}

const char* Name(PhotoState state) {
  switch (state) {
    case PhotoState::kAdjusted:
      return "adjusted";
    case PhotoState::kNoDatum:
      return "no datum";
    case PhotoState::kUndetermined:
      break;
  }
  return "undetermined";
}

const char* Name(CalibrationState state) {
  switch (state) {
    case CalibrationState::kEstimated:
      return "estimated";
    case CalibrationState::kInsignificant:
      return "insignificant";
    case CalibrationState::kNotDetermined:
      break;
  }
  return "not determined";
}

}  // namespace orient::block
