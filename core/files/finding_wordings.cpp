#include "core/files/finding_wordings.h"

namespace orient {

// In the order of Reason; a test checks that both agree.
const std::vector<Wording>& Wordings() {  // NOLINT(readability-function-size): a table
  static const std::vector<Wording> kWordings = {
      {Reason::kStated, "stated", "{where}"},
      {Reason::kScanUnusable, "scan_unusable", "{where}"},
      {Reason::kImageSizeIsNotTheCameras, "image_size_is_not_the_cameras",
       "The image has {where}: use the camera file that belongs to it, or the uncropped image."},
      {Reason::kMarksNotFound, "marks_not_found",
       "The camera's marks were not found: wrong camera file, marks outside the scan, or a wrong "
       "pixel size (--pixel-size-um; in a block file pixel_size_um under [scan])."},
      {Reason::kMarksMayBeChance, "marks_may_be_chance",
       "The marks found may be due to chance ({value:.1f} nats, {limit:.1f} are needed{unused}): "
       "too few of them, too faint, or a wrong camera file. Missing ones can be measured by hand "
       "(--measurements)."},
      {Reason::kTooManyReadings, "too_many_readings",
       "Too many marks and candidates to rule out another interpretation: give orientation, "
       "polarity or pixel size, whichever is known (by option, or under [scan] in a block file)."},
      {Reason::kRivalReading, "rival_reading",
       "Another interpretation of the marks is nearly as probable (margin {value:.1f} nats, "
       "{limit:.0f} are needed{unused})."},
      {Reason::kMarksOnOneLine, "marks_on_one_line",
       "The marks found lie on one line and determine no transform: measure others by hand "
       "(--measurements), or scan the whole film."},
      {Reason::kFewMarks, "few_marks",
       "Only {value:.0f} mark{s} could be used; {limit:.0f} are needed{unused}."},
      {Reason::kWrongMarkUnclear, "wrong_mark_unclear",
       "A mark contradicts the others, which are too few to tell whether it or one of these "
       "is wrong: {where}."},
      {Reason::kScaleDifference, "scale_difference",
       "The scales of the two axes differ by {value:.1f} %: implausible for film or scanner."},
      {Reason::kShear, "shear",
       "The axes are sheared by {value:.1f} mrad: implausible for film or scanner."},
      {Reason::kPixelSizeIsNotAsStated, "pixel_size_is_not_as_stated",
       "The pixel size is {value:.2f} um from the marks, but {limit:.2f} um from the resolution "
       "tag or as stated: another camera's marks, or a wrong resolution."},
      {Reason::kPixelSizeUnsure, "pixel_size_unsure",
       "The pixel size ({value:.2f} um) follows from the camera alone: a smaller or larger camera "
       "with similar marks would fit as well; state it (--pixel-size-um; in a block file "
       "pixel_size_um under [scan])."},
      {Reason::kRivalScanner, "rival_scanner",
       "A desktop scan of all these marks and a photogrammetric one with one mark misplaced are "
       "almost equally probable ({value:.1f} nats apart): state which with 'orient interior "
       "--scanner', or measure the marks by hand (--measurements)."},
      {Reason::kRivalScanOrientation, "rival_scan_orientation",
       "Another scan orientation is nearly as probable ({value:.1f} nats apart, {limit:.0f} are "
       "needed): give --orientation."},
      {Reason::kLargeSigma0, "large_sigma0",
       "sigma0 of {value:.0f} um exceeds what film and scanner explain ({limit:.0f} um): look for "
       "a wrongly located mark."},
      {Reason::kFilmDistorted, "film_distorted",
       "Scanner, print or film deform the image, or the camera file's mark positions are inexact: "
       "an affine transform leaves sigma0 = {value:.0f} um."},
      {Reason::kBlackAndWhite, "black_and_white",
       "The scan is bilevel (black and white, no grey values): marks may be off by a pixel, and "
       "their precision is unknown. Scan the film in greyscale."},
      {Reason::kReseauContradictory, "reseau_contradictory",
       "The reseau crosses contradict one another: no smooth film deformation explains their "
       "positions. Check the crosses in the camera file."},
      {Reason::kReseauCorrection, "reseau_correction",
       "Corrected by a reseau of {value:.0f} crosses: {where}."},
      {Reason::kFewReseauCrosses, "few_reseau_crosses",
       "Only {value:.0f} crosses agree with their neighbours; {limit:.0f} are needed ({where})."},
      {Reason::kPolarityUnlikeMarks, "polarity_unlike_marks",
       "Read as a {where} the marks are {value:.1f} nats more probable than in the polarity given: "
       "check --polarity (in a block file polarity under [scan])."},
      {Reason::kOrientationUnlikeLayout, "orientation_unlike_layout",
       "The marks' calibrated positions fit scan orientation {where} as given ({value:.1f} nats): "
       "check --orientation."},
      {Reason::kOrientationUnlikeSigns, "orientation_unlike_signs",
       "The film's symbols or border show scan orientation {where} as given: check --orientation."},
      {Reason::kSignsContradictory, "signs_contradictory",
       "Identification symbols, border and mark positions contradict one another ({where} against "
       "the others): check the camera file's symbols, data_strip, border and fiducials."},
      {Reason::kSignNotClear, "sign_not_clear",
       "{where} alone contradicts the scan orientation that all others indicate; perhaps misread."},
      {Reason::kOrientationOpen, "orientation_open",
       "The marks leave the scan orientation open ({where}); the transform given is for the "
       "first of these."},
      {Reason::kBorderOffScan, "border_off_scan",
       "Outside the scan, and so without effect on the scan orientation: {where}. Scan the film "
       "with its border, or correct data_strip and border in the camera file."},
      {Reason::kOrientationOfRoll, "orientation_of_roll",
       "The scan orientation is that of the other photos of the roll; this photo alone leaves it "
       "open ({where}). If their orientations differ, give --roll differing."},
      {Reason::kCameraUnknown, "camera_unknown",
       "The camera is unknown: {where} Name the camera with --camera, or draw its marks (see "
       "the documentation, page cameras)."},
      {Reason::kNearestCameras, "nearest_cameras", "Nearest: {where}."},
      {Reason::kCamerasThatFit, "cameras_that_fit", "{where}"},
      {Reason::kCameraPixelSizeOff, "camera_pixel_size_off",
       "With this camera a pixel is {value:.1f} % {where} than stated: perhaps another camera, "
       "with other mark positions."},
      {Reason::kClickOffMark, "click_off_mark",
       "Clicks that lie off the measured mark (the measurement is used); check them: {where}."},
      {Reason::kClickContradicted, "click_contradicted",
       "The other marks, or the image there, contradict the clicks on {where}: not used. Marks "
       "confused?"},
      {Reason::kClickNotSeen, "click_not_seen",
       "No mark that agrees with the others was found where {where} was clicked: not used. "
       "If the mark is visible to the eye only, declare the click exact."},
      {Reason::kExactClicks, "exact_clicks",
       "Marks taken from exact clicks without measurement: {value:.0f}; for status ok, {limit:.0f} "
       "others must be measured in the scan."},
      {Reason::kAcceptedByPerson, "accepted_by_person", "Accepted by {where}."},
      {Reason::kRejectedByPerson, "rejected_by_person", "Rejected by {where}."},
      {Reason::kRollPixelColumns, "roll_pixel_columns",
       "Unlike the other photos of the roll: its pixel size along columns is {value:.3f} um on the "
       "film, theirs {limit:.3f} um."},
      {Reason::kRollPixelRows, "roll_pixel_rows",
       "Unlike the other photos of the roll: its pixel size along rows is {value:.3f} um on the "
       "film, theirs {limit:.3f} um."},
      {Reason::kRollScaleDifference, "roll_scale_difference",
       "Unlike the other photos of the roll: the scales of its two axes differ by {value:.2f} %, "
       "theirs by {limit:.2f} %."},
      {Reason::kRollShear, "roll_shear",
       "Unlike the other photos of the roll: its axes are sheared by {value:.2f} mrad, theirs by "
       "{limit:.2f} mrad."},
      {Reason::kRollSigma0, "roll_sigma0",
       "Unlike the other photos of the roll: its sigma0 is {value:.1f} um, theirs {limit:.1f} um."},
      {Reason::kPhotoUnusable, "photo_unusable", "{where}"},
      {Reason::kNoApproximation, "no_approximation", "no approximation: {where}"},
      {Reason::kBelowGround, "below_ground",
       "its approximate position lies below the ground: z {value:.0f}, ground height {limit:.0f}; "
       "correct it{where}"},
      {Reason::kOutsideDem, "outside_dem",
       "the DEM {where}; give a DEM that does, or correct the approximation"},
      {Reason::kInteriorFailed, "interior_failed", "its interior orientation failed{where}"},
      {Reason::kInteriorWeak, "interior_weak", "its interior orientation is weak"},
      {Reason::kInteriorOfAnotherScan, "interior_of_another_scan", "{where}"},
      {Reason::kScanOrientationExcluded, "scan_orientation_excluded",
       "the pose was found in scan orientation {where}, for which the interior orientation no "
       "longer has a transform; run again with --overwrite"},
      {Reason::kNoPatches, "no_patches",
       "{where} has no control patch under the photo's footprint; harvest patches there, or "
       "correct the approximation"},
      {Reason::kNoFirstPose, "no_first_pose", "{where}"},
      {Reason::kNothingAlike, "nothing_alike",
       "the search of the whole photo found nothing like the patches at any kappa{where}"},
      {Reason::kNothingAlikeAfterPrior, "nothing_alike_after_prior",
       "the search of the whole photo found nothing like the patches at any kappa either{where}"},
      {Reason::kNotSearchedAsAWhole, "not_searched_as_a_whole",
       "the whole photo could not be searched: at the reduced resolution too few patches are "
       "large enough and they form no mosaic; give a better approximation or harvest more densely"},
      {Reason::kNoConsensus, "no_consensus",
       "only {value:.0f} of {limit:.0f} patches agree on a pose within {where} of the prediction: "
       "chance could produce that. Either the approximation is worse than its stated accuracy, or "
       "the patches do not show this place, or the scene has changed"},
      {Reason::kTooFewPreciseMatches, "too_few_precise_matches",
       "only {value:.0f} patches could be matched precisely, {limit:.0f} are needed"},
      {Reason::kMatchesAgreeOnNoPose, "matches_agree_on_no_pose",
       "{value:.0f} of {limit:.0f} patches were matched precisely, but no pose fits them"},
      {Reason::kTooFewAgree, "too_few_agree",
       "only {value:.0f} patches agree, at least {limit:.0f} are needed"},
      {Reason::kPatchesOverlap, "patches_overlap",
       "the patches that agree overlap: only {value:.0f} places, at least {limit:.0f} are needed"},
      {Reason::kAgreementMayBeChance, "agreement_may_be_chance",
       "matched precisely, only {value:.0f} of {limit:.0f} patches agree: chance could produce "
       "that"},
      {Reason::kMostContradict, "most_contradict",
       "more than half of the matched patches contradict the pose"},
      {Reason::kHarvestMoreDensely, "harvest_more_densely",
       "only {value:.0f} patches lie under the photo: harvest more densely there "
       "(--max-per-photo), or from more photos"},
      {Reason::kHarvestLargerChips, "harvest_larger_chips",
       "a patch is only {value:.0f} px wide in this photo: harvest larger chips (--chip-px; in a "
       "block file chip_px under [control]), or from images at its scale"},
      {Reason::kContradictsApproximation, "contradicts_approximation",
       "the pose lies {value:.0f} sigma from its approximation: check the approximation (accuracy "
       "as stated or by default, datum, heights) and the principal distance; or {where} wrong"},
      {Reason::kFewPlaces, "few_places",
       "patches agree at {value:.0f} places; {limit:.0f} are needed to judge the precision"},
      {Reason::kPoorSpread, "poor_spread",
       "the patches that agree cover {value:.1f} % of the photo: the rest is uncontrolled"},
      {Reason::kPoorlyDetermined, "poorly_determined",
       "the pose is poorly determined: in the worst corner of the frame its projection is "
       "uncertain by {value:.2f} px, the target is {limit:.2f} px"},
      {Reason::kResidualTrend, "residual_trend",
       "the residuals show a {where} of {value:.2f} px (RMS); the covariance of the photo alone "
       "allows for that much, but the pose may have absorbed more"},
      {Reason::kSourceContradicted, "source_contradicted",
       "{limit:.0f} patches of source {where} agree with one another but not with the pose: they "
       "lie {value:.1f} px from its prediction; either that source or those used are wrong"},
      {Reason::kPatchesAgreeElsewhere, "patches_agree_elsewhere",
       "{limit:.0f} patches agree with one another, {value:.1f} px off the pose ({where}): "
       "either they or those that were used are displaced"},
      {Reason::kPointsContradictOneAnother, "points_contradict_one_another",
       "the measured ground points contradict one another, and it is unclear which is wrong: "
       "{where}; measure one more, or look at these"},
      {Reason::kPointsOnNoPose, "points_on_no_pose",
       "no pose fits the image measurements of ground points {where}"},
      {Reason::kTooFewPoints, "too_few_points",
       "measured control points: {value:.0f}; {limit:.0f} are needed, or three and an "
       "approximation"},
      {Reason::kPointsWrong, "points_wrong",
       "ground points that contradict the others and are not used; check them: {where}"},
      {Reason::kPointsOffPose, "points_off_pose",
       "measured ground points that the pose projects elsewhere: {where}"},
      {Reason::kByPointsAlone, "by_points_alone",
       "oriented by {value:.0f} measured points alone ({limit:.0f} are needed without "
       "patches): {where}"},
      {Reason::kLittleOtherControl, "little_other_control",
       "oriented by measured ground points and ties: besides its own, the block has {value:.0f} "
       "control points and patches; {limit:.0f} are needed to show whether its own are right"},
      {Reason::kPatchesNotThere, "patches_not_there",
       "the {value:.0f} patches of its area do not confirm it: {where}"},
      {Reason::kPointsOffDem, "points_off_dem",
       "the DEM lies {value:.0f} m {where} the measured ground points: their height datums differ, "
       "or their coordinates are wrong"},
      {Reason::kMeasuredMarksContradict, "measured_marks_contradict",
       "its measured marks lie up to {value:.1f} mm off the camera file's positions: {where}; look "
       "for marks that were confused"},
      {Reason::kKappaWithOrientation, "kappa_with_scan_orientation",
       "{value:.0f} scan orientations are equally possible, each with a kappa of its own, and the "
       "approximation does not decide between them: this kappa belongs to {where}"},
      {Reason::kMeasuredPhotosUnknown, "measured_photos_unknown",
       "measurements or decisions for photos that are not in this run: {where}"},
      {Reason::kStartedByPoints, "started_by_points",
       "the search began from a pose computed from {value:.0f} measured ground points"},
      {Reason::kPrincipalDistanceNotEstimated, "principal_distance_not_estimated",
       "the principal distance could not be estimated: the pose is valid with the camera file's"},
      {Reason::kPrincipalDistanceNotConverged, "principal_distance_not_converged",
       "pose and principal distance did not converge"},
      {Reason::kPrincipalDistanceEstimated, "principal_distance_estimated",
       "the pose was computed with a principal distance of {value:.3f} mm, not with the camera "
       "file's {limit:.3f} mm"},
      {Reason::kPrincipalDistanceUndetermined, "principal_distance_undetermined",
       "the photo does not determine its principal distance: its sigma is still {value:.3f} mm "
       "({limit:.3f} mm a priori); over level ground the flying height absorbs it"},
      {Reason::kPrincipalDistanceContradicted, "principal_distance_contradicted",
       "the patches fit a principal distance of {value:.3f} mm better than the camera file's "
       "{limit:.3f} mm, which one deformed source of patches may also cause: {where}"},
      {Reason::kDemHasHoles, "dem_has_holes",
       "the DEM has no height under {value:.0f} of the {limit:.0f} matched patches: it has a hole "
       "or ends there"},
      {Reason::kDemUnlikePatches, "dem_unlike_patches",
       "the DEM's heights differ from the matched patches' by {value:.0f} m (one sigma; at most "
       "{limit:.0f} m is expected): is the DEM a surface model, of another date, or are the "
       "patches or the DEM of another place?"},
      {Reason::kDemDatum, "dem_datum",
       "the DEM lies {value:.0f} m {where} the matched patches (spread {limit:.0f} m): check both "
       "height datums; the pose refers to the datum of the patches"},
      {Reason::kNotLearnt, "not_learnt",
       "its matches were not recorded in the patch database: {where}"},
      {Reason::kPictureNotWritten, "picture_not_written", "its picture is missing: {where}"},
      {Reason::kUnusableInBlock, "unusable_in_block", "{where}"},
      {Reason::kNoTies, "no_ties", "it has no tie points with its neighbours"},
      {Reason::kNotConnected, "not_connected", "its ties do not connect it to control{where}"},
      {Reason::kFewTies, "few_ties",
       "tie points with its neighbours that could be used: {value:.0f}; {limit:.0f} are needed"},
      {Reason::kTiesContradict, "ties_contradict",
       "more than half of its tie points contradict its pose"},
      {Reason::kTiesUncontrolled, "ties_uncontrolled",
       "its tie points do not check one another: too few, or most connect it to one other photo "
       "only"},
      {Reason::kTiesImprecise, "ties_imprecise",
       "its tie points determine its pose poorly: in the worst corner of the frame its projection "
       "is uncertain by {value:.2f} px, the target is {limit:.2f} px"},
      {Reason::kOrientedByNeighbours, "oriented_by_neighbours",
       "oriented by {value:.0f} tie points with its neighbours, not by control patches "
       "alone{where}"},
      {Reason::kNeighboursWeak, "neighbours_weak",
       "the photos that it depends on are weak themselves"},
      {Reason::kMovedByBlock, "moved_by_block",
       "the block moved it by {value:.1f} sigma from the pose given by its own patches or points, "
       "or these fit the block much worse: check them, its ties, and whether all sources agree"},
      {Reason::kBlockNotConverged, "block_not_converged",
       "the block's adjustment did not converge{where}"},
      {Reason::kKeypointsUnconfirmed, "keypoints_unconfirmed", "{where}"},
      {Reason::kFailedWithoutPriors, "failed_without_priors",
       "without GNSS and approximations it cannot be oriented"},
      {Reason::kWeakWithoutPriors, "weak_without_priors",
       "without GNSS and approximations it is weak{where}"},
      {Reason::kBlockNotConvergedWithoutPriors, "block_not_converged_without_priors",
       "without GNSS and approximations the block's adjustment does not converge"},
      {Reason::kAdjustmentNotConverged, "adjustment_not_converged",
       "The adjustment did not converge."},
      {Reason::kBlockWithoutDatum, "block_without_datum",
       "The block has too little control for position, attitude and scale."},
      {Reason::kBlockWithoutControl, "block_without_control",
       "The block has no control: its position follows from approximations or GNSS alone."},
      {Reason::kBlockPoorlyControlled, "block_poorly_controlled",
       "The block has control on one line or at one place only: approximations or GNSS determine "
       "the rest."},
      {Reason::kPartWithoutDatum, "part_without_datum",
       "Photo{s} {where} {are} adjusted apart from the rest of the block. {They_have} too little "
       "control for position, attitude and scale."},
      {Reason::kPartWithoutControl, "part_without_control",
       "Photo{s} {where} {are} adjusted apart from the rest of the block. {They_have} no control: "
       "{their} position follows from approximations or GNSS alone."},
      {Reason::kPartPoorlyControlled, "part_poorly_controlled",
       "Photo{s} {where} {are} adjusted apart from the rest of the block. {They_have} control on "
       "one line or at one place only: approximations or GNSS determine the rest."},
      {Reason::kPartNotConnected, "part_not_connected",
       "Photo{s} {where} {are} not connected to the rest of the block."},
      {Reason::kGnssDisagreesEverywhere, "gnss_disagrees_everywhere",
       "GNSS contradicts the block everywhere; no position is used: check datum, height system, "
       "accuracies and names."},
      {Reason::kGnssRejected, "gnss_rejected",
       "GNSS contradicts the block and is not used: {where}."},
      {Reason::kGnssPerhapsOfAnotherDatum, "gnss_perhaps_of_another_datum",
       "{value:.0f} of {limit:.0f} GNSS positions differ from control by the same shift, {where}: "
       "another datum, a geoid, the antenna's offset, or a wrong principal distance? The block "
       "follows control."},
      {Reason::kGnssWorseThanStated, "gnss_worse_than_stated",
       "GNSS positions fit {value:.0f} times worse than stated, and their weight is reduced "
       "accordingly."},
      {Reason::kControlWorseThanStated, "control_worse_than_stated",
       "Control fits {value:.0f} times worse than stated, and its weight is reduced accordingly."},
      {Reason::kApproximationsRejected, "approximations_rejected",
       "Approximations that contradict the block are not used as observations: {where}."},
      {Reason::kApproximationsWorseThanStated, "approximations_worse_than_stated",
       "Approximations fit {value:.1f} times worse than stated{where}"},
      {Reason::kPhotosUndetermined, "photos_undetermined",
       "Too few or poorly distributed observations: {where}."},
      {Reason::kDistanceLeftOpen, "distance_left_open",
       "The block does not determine the principal distance (sigma {value:.3f} mm); that of the "
       "camera file is used. If it is wrong, the projection centres' heights err by more than "
       "their sigmas."},
      {Reason::kAdjustedWithoutPriors, "adjusted_without_priors",
       "with GNSS and approximations as observations the block does not converge: adjusted without "
       "them"},
      {Reason::kAdjustedInSubBlocks, "adjusted_in_sub_blocks",
       "Adjusted in {value:.0f} overlapping sub-blocks{where}."},
      {Reason::kNoPoseCovariance, "no_pose_covariance",
       "pose_covariance.csv is not written: it needs a converged adjustment with at least one "
       "accepted pose and at most {limit:.0f} photos"},
      {Reason::kInputsChanged, "inputs_changed",
       "oriented again, as their inputs changed ({first}): {rest}"},
      {Reason::kNoTiesFromPhoto, "no_ties_from_photo", "{first} gives no tie points: {rest}"},
      {Reason::kSameImage, "same_image",
       "{where} are the same image under {value:.0f} names: leave all but one out"},
      {Reason::kNeighboursNotTried, "neighbours_not_tried",
       "The remaining photos could not be tried with their neighbours' patches: {where}"},
      {Reason::kStripPhotosAbsent, "strip_photos_absent",
       "the strips list {value:.0f} photo{s} that {are} not in the block or cannot be used; their "
       "places in the strips stay vacant: {where}"},
      {Reason::kLocatedByOwnFiles, "located_by_own_files",
       "{value:.0f} photo{s} {are} located by the GNSS position in {their} own file{s}"},
      {Reason::kFocalLengthIsNotTheCameras, "focal_length_is_not_the_cameras",
       "the focal length in these photos' files ({value:.4g} mm in the last of them) is not the "
       "camera file's principal distance ({limit:.4g} mm): {where}; is this their camera file?"},
      {Reason::kApproximationsOfOtherPhotos, "approximations_of_other_photos",
       "{first} lists {value:.0f} photo{s} that {are} not in the block: {rest}"},
      {Reason::kAngleColumnsIgnored, "angle_columns_ignored",
       "{first} has {value:.0f} column{s} that {are} ignored, since only omega, phi and kappa in "
       "degrees are read: {rest}"},
      {Reason::kRowsWithoutPosition, "rows_without_position",
       "{first} has no complete position of {value:.0f} photo{s}, which {are} treated as if not "
       "listed: {rest}"},
      {Reason::kOtherPhotosSetAside, "other_photos_set_aside",
       "an earlier run's results of {value:.0f} photo{s} that {are} not in the block ({rest}) were "
       "moved to {first}"},
      {Reason::kPhotoNotInQuicklook, "photo_not_in_quicklook",
       "photo {where} could not be read for the quicklook"},
      {Reason::kNoQuicklook, "no_quicklook", "no quicklook: {where}"},
      {Reason::kExportSource, "export_source", "exports: {where}"},
      {Reason::kExportNote, "export_note", "export {where}"},
      {Reason::kPatchBehindCamera, "patch_behind_camera", "behind the camera in the final pose"},
      {Reason::kPatchOutsidePhoto, "patch_outside_photo", "outside the photo in the final pose"},
      {Reason::kPatchCovered, "patch_covered", "under a fiducial mark or writing"},
      {Reason::kPatchHidden, "patch_hidden", "hidden by terrain"},
      {Reason::kPatchTooSmall, "patch_too_small", "too small at the photo's resolution"},
      {Reason::kNoCorrelationPeak, "no_correlation_peak",
       "no correlation peak in the search window"},
      {Reason::kLowCorrelation, "low_correlation", "best correlation below the threshold"},
      {Reason::kCorrelationAmbiguous, "correlation_ambiguous",
       "ambiguous: a second place correlates as well"},
      {Reason::kMatchingNotConverged, "matching_not_converged",
       "least-squares matching did not converge"},
      {Reason::kMatchingOfAnotherTexture, "matching_of_another_texture",
       "least-squares matching found another texture"},
      {Reason::kMatchingDisagrees, "matching_disagrees",
       "correlation and least-squares matching disagree"},
      {Reason::kTextureTooWeak, "texture_too_weak", "texture too weak for a precise position"},
      {Reason::kNoGradients, "no_gradients", "no gradients in the search window"},
      {Reason::kGradientsAmbiguous, "gradients_ambiguous",
       "ambiguous: the gradients of a second place fit as well"},
      {Reason::kGradientsNotConverged, "gradients_not_converged",
       "least-squares matching of the gradients did not converge"},
      {Reason::kGradientsDisagree, "gradients_disagree",
       "correlation and least-squares matching of the gradients disagree"},
      {Reason::kGradientsTooWeak, "gradients_too_weak",
       "gradients too weak for a precise position"},
      {Reason::kFoundElsewhereInPatch, "found_elsewhere_in_patch",
       "matching back from the photo ends at another place in the patch"},
      {Reason::kPatchFoundWithNoOthers, "patch_found_with_no_others",
       "not found at a place that agrees with other patches before the search ended"},
      {Reason::kPatchContradictsOthers, "patch_contradicts_others",
       "does not agree with the other patches"},
      {Reason::kPatchContradictsBlock, "patch_contradicts_block",
       "does not agree with the block{where}"},
  };
  return kWordings;
}

}  // namespace orient
