/*
 * scphd: single-cluster PHD SLAM in fixed memory. Made from the crate scphd-capi by cbindgen; do not edit.
 *
 * The library keeps nothing: a filter and each of its detectors live in memory of the user's, SCPHD_SIZE_... bytes, aligned to
 * SCPHD_ALIGNMENT, and zero at first, which is not to be touched or moved while they do. Calls on different memories may run at the
 * same time. Every call says how it ended; what is refused changes nothing. Units are part of the names; angles grow to the left.
 */

#ifndef SCPHD_H
#define SCPHD_H

#include <stddef.h>
#include <stdint.h>

/* Alignment of every memory, bytes. */
#define SCPHD_ALIGNMENT 8

/* A memory of so many bytes, aligned: `static SCPHD_MEMORY(memory, SCPHD_SIZE_JOINT_40);` is zero. */
#define SCPHD_MEMORY(name, bytes) uint64_t name[(bytes) / 8]

/* Mixture in the plane: 32 particles of two samples, 320 pages of features, 32 to a map, 256 in view; 128 pages of moving ones. */
#define SCPHD_SET_PLANE_32X2 101
#define SCPHD_SIZE_PLANE_32X2 203776

/* Mixture in the plane: four informed particles, 128 pages of features, 32 to a map, 256 in view; none that move. */
#define SCPHD_SET_PLANE_INFORMED_4 102
#define SCPHD_SIZE_PLANE_INFORMED_4 53248

/* The same with 64 pages of moving features, 16 to a map, 128 in view. */
#define SCPHD_SET_PLANE_INFORMED_4_MOVING 103
#define SCPHD_SIZE_PLANE_INFORMED_4_MOVING 100352

/* Joint map in the plane: 40 features, scans of 32 measurements. */
#define SCPHD_SET_JOINT_40 201
#define SCPHD_SIZE_JOINT_40 20480

/* Joint map in the plane: 100 features, scans of 32 measurements. */
#define SCPHD_SET_JOINT_100 202
#define SCPHD_SIZE_JOINT_100 93184

/* Mixture under water: 16 informed particles, 160 pages of features, 24 to a map, 256 in view; none that move. */
#define SCPHD_SET_WATER_INFORMED_16 301
#define SCPHD_SIZE_WATER_INFORMED_16 94208

/* Detector of range and bearing: scans of 32 measurements. */
#define SCPHD_SET_RANGE_BEARING_32 401
#define SCPHD_SIZE_RANGE_BEARING_32 1024

/* Detector of range and bearing: scans of 128 measurements. */
#define SCPHD_SET_RANGE_BEARING_128 402
#define SCPHD_SIZE_RANGE_BEARING_128 2816

/* Detector of bearings alone: scans of 64 measurements. */
#define SCPHD_SET_BEARING_64 501
#define SCPHD_SIZE_BEARING_64 1280

/* Detector of range, bearing and elevation: scans of 64 measurements. */
#define SCPHD_SET_SONAR_64 601
#define SCPHD_SIZE_SONAR_64 2048


// The version of this interface. It changes whenever a program that was compiled against another header could not work.
#define SCPHD_ABI_VERSION 2

// No candidate explained the scan: the vehicle is lost, or the intensities of clutter and births are both zero.
#define SCPHD_HEALTH_UNEXPLAINED_SCAN 1

// The pose hangs on a single sample.
#define SCPHD_HEALTH_DEGENERATE 2

// A map had so little room that components were dropped.
#define SCPHD_HEALTH_PRUNING_TIGHTENED 4

// A map was left as predicted for want of room.
#define SCPHD_HEALTH_MAP_NOT_UPDATED 8

// Components were lost for want of room.
#define SCPHD_HEALTH_COMPONENTS_LOST 16

// Rounding had spoilt a covariance; it was repaired.
#define SCPHD_HEALTH_COVARIANCE_REPAIRED 32

// A pose left the range of single precision, and stayed where it was.
#define SCPHD_HEALTH_POSE_REJECTED 64

// Innovations are more than twice what their covariances say: the noise is set too low, or the vehicle is elsewhere.
#define SCPHD_HEALTH_INNOVATION_HIGH 128

// Predictions since the scan before were refused.
#define SCPHD_HEALTH_PREDICTION_REFUSED 256

// Known landmarks are missed, and measurements come from elsewhere: a hundred to one that the vehicle is not where it is taken to be.
#define SCPHD_HEALTH_DIVERGENCE_SUSPECTED 512

// The same, ten thousand to one. It stays until the pose is set or made uncertain, or what was known is detected again.
#define SCPHD_HEALTH_LOST 1024

// No scan for eight times as long as usual, and for a second at least.
#define SCPHD_HEALTH_INPUT_LOST 2048

// A scrubbing has mended what memory faults had left.
#define SCPHD_HEALTH_STATE_REPAIRED 4096

// Far more is measured than usual that nothing known explains.
#define SCPHD_HEALTH_CLUTTER_HIGH 8192

// Of late a fifth of the detections to be expected of known landmarks is missing.
#define SCPHD_HEALTH_DETECTIONS_LOW 16384

// Samples are drawn from the motion.
#define SCPHD_PROPOSAL_BLIND 1

// Samples are drawn from a Gaussian that the scan has been taken into.
#define SCPHD_PROPOSAL_INFORMED 2

// The estimated features are the heaviest components (5.2.7).
#define SCPHD_EXTRACTION_HEAVIEST 1

// They are the highest peaks of the intensity.
#define SCPHD_EXTRACTION_PEAKS 2

// A car: speed of a wheel's encoder and steering angle (5.25-5.27).
#define SCPHD_VEHICLE_CAR 1

// A robot that turns in place: speed and turn rate, along exact arcs.
#define SCPHD_VEHICLE_ROBOT 2

// A vehicle that moves sideways too, on mecanum wheels or legs: speed ahead and to the left, and turn rate, along exact arcs.
#define SCPHD_VEHICLE_HOLONOMIC 3

// How a call ended. What is refused leaves the filter as it was, but for the time of a prediction: see `scphd_plane_predict_car`.
enum scphd_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // As asked.
  SCPHD_STATUS_OK = 0,
  // A pointer is null that must not be.
  SCPHD_STATUS_NULL_POINTER = 1,
  // A pointer is not aligned as its type asks for.
  SCPHD_STATUS_MISALIGNED = 2,
  // The memory is smaller than its set needs.
  SCPHD_STATUS_MEMORY_TOO_SMALL = 3,
  // There is no such set, or it is not one of this function.
  SCPHD_STATUS_UNKNOWN_SET = 4,
  // Something runs in this memory already. Release it first.
  SCPHD_STATUS_ALREADY_STARTED = 5,
  // Nothing was started in this memory, or it was copied from elsewhere.
  SCPHD_STATUS_NOT_STARTED = 6,
  // What runs in this memory is of another kind, or of another set.
  SCPHD_STATUS_WRONG_MEMORY = 7,
  // Another call works on the same memory: an interrupt, or a second thread.
  SCPHD_STATUS_BUSY = 8,
  // The last call did not come to its end, so that what it left cannot be gone on from. Start anew.
  SCPHD_STATUS_INTERRUPTED = 9,
  // `struct_size` is not the size that this library knows: not set, or of another version of the header.
  SCPHD_STATUS_WRONG_STRUCT_SIZE = 10,
  // The header is of another version than the library.
  SCPHD_STATUS_WRONG_VERSION = 11,
  // An array is longer than memory can be.
  SCPHD_STATUS_ARRAY_TOO_LONG = 12,
  // A field is out of range; the reason names it.
  SCPHD_STATUS_OUT_OF_RANGE = 20,
  // More particles or candidates are configured than the set has room for.
  SCPHD_STATUS_TOO_MANY_PARTICLES = 21,
  // Births of features that move are above 0, and the set has no room for such.
  SCPHD_STATUS_NO_ROOM_FOR_MOVING = 22,
  // What the memory holds is of another configuration than is given.
  SCPHD_STATUS_OTHER_CONFIGURATION = 23,
  // What the memory holds is damaged.
  SCPHD_STATUS_DAMAGED = 24,
  // A pose is not finite, or a coordinate above 1e8.
  SCPHD_STATUS_BAD_POSE = 25,
  // The filter has not been reset to a pose yet.
  SCPHD_STATUS_NOT_RESET = 26,
  // The time step is negative or not finite.
  SCPHD_STATUS_BAD_TIME_STEP = 27,
  // A control is not finite or outside of the motion's domain, or of another vehicle than is configured.
  SCPHD_STATUS_BAD_CONTROL = 28,
  // No vehicle makes such a step.
  SCPHD_STATUS_IMPLAUSIBLE = 29,
  // The scan has more measurements than its detector has room for.
  SCPHD_STATUS_TOO_MANY_MEASUREMENTS = 30,
  // A measurement is not finite.
  SCPHD_STATUS_BAD_MEASUREMENT = 31,
  // The noise of a sensor or a fix is not positive definite.
  SCPHD_STATUS_BAD_NOISE = 32,
  // Refused for another reason.
  SCPHD_STATUS_REFUSED = 99,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum scphd_status scphd_status;
#else
typedef int32_t scphd_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A detector of bearings alone, in its memory. Only a mixture takes its scans.
typedef struct scphd_bearing_detector scphd_bearing_detector;

// A joint map, in its memory.
typedef struct scphd_joint scphd_joint;

// A mixture in the plane, in its memory.
typedef struct scphd_plane scphd_plane;

// A detector of range and bearing, in its memory.
typedef struct scphd_range_bearing_detector scphd_range_bearing_detector;

// A detector of range, bearing and elevation, in its memory.
typedef struct scphd_sonar_detector scphd_sonar_detector;

// A mixture under water, in its memory.
typedef struct scphd_water scphd_water;

// The part of the plane that a sensor detects features in. The probability of detection falls linearly with range, and to zero
// over a ramp around every edge.
typedef struct scphd_window {
  // Least range, m; 0 for none.
  float range_min_m;
  // Greatest range, m.
  float range_max_m;
  // Half width of the soft edge at either range, m.
  float range_edge_m;
  // Middle of the window, rad.
  float bearing_center_rad;
  // Half width of the window, rad; pi or more for a full circle.
  float bearing_half_width_rad;
  // Half width of the soft edge at either side, rad.
  float bearing_edge_rad;
  // Probability of detection at range zero, in [0, 1).
  float probability_near;
  // At the greatest range.
  float probability_far;
} scphd_window;

// Where a sensor sits on its vehicle and how it is turned: from where the pose is, x ahead, y to the left, z upwards; roll first, then
// pitch, then yaw. In the plane up, roll and pitch must be 0.
typedef struct scphd_mounting {
  // Ahead, m.
  float forward_m;
  // To the left, m.
  float left_m;
  // Upwards, m.
  float up_m;
  // About the axis ahead, rad.
  float roll_rad;
  // About the axis to the left, rad.
  float pitch_rad;
  // About the axis upwards, rad.
  float yaw_rad;
} scphd_mounting;

// What there is to say of such a sensor.
typedef struct scphd_range_bearing_config {
  // `sizeof(scphd_range_bearing_config)`, set by the caller.
  uint32_t struct_size;
  // Standard deviation of the range, m.
  float range_sigma_m;
  // Standard deviation of the bearing, rad.
  float bearing_sigma_rad;
  // Where it sees.
  struct scphd_window window;
  // False measurements to expect of a scan.
  float clutter_per_scan;
  // Intensity of births of features that stand still, 1/(m rad).
  float births_still;
  // Intensity of births of features that move, 1/(m rad).
  float births_moving;
  // Where it sits.
  struct scphd_mounting mounting;
} scphd_range_bearing_config;

// Why a configuration was refused.
typedef struct scphd_reason {
  // `sizeof(scphd_reason)`, set by the caller.
  uint32_t struct_size;
  // One line in UTF-8 that ends with a zero, as "prune_weight must be above 0 and below 1". Empty where no field is to blame.
  char text[124];
} scphd_reason;

// What there is to say of such a sensor. One bearing has no inverse: features are born on rings around the sensor.
typedef struct scphd_bearing_config {
  // `sizeof(scphd_bearing_config)`, set by the caller.
  uint32_t struct_size;
  // Standard deviation of the bearing, rad.
  float bearing_sigma_rad;
  // Where it sees.
  struct scphd_window window;
  // False measurements to expect of a scan.
  float clutter_per_scan;
  // Range of the innermost ring of births, m.
  float births_nearest_m;
  // Range of the outermost ring, m.
  float births_farthest_m;
  // Rings, at least 2. The components of all rings must fit into the view of the set.
  uint32_t births_rings;
  // Components in a ring.
  uint32_t births_sectors;
  // Weight of each: features that appear there between two scans.
  float births_weight;
  // Where it sits.
  struct scphd_mounting mounting;
} scphd_bearing_config;

// What there is to say of such a sensor.
typedef struct scphd_sonar_config {
  // `sizeof(scphd_sonar_config)`, set by the caller.
  uint32_t struct_size;
  // Standard deviation of the range, m.
  float range_sigma_m;
  // Standard deviation of the bearing, rad.
  float bearing_sigma_rad;
  // Standard deviation of the elevation, rad.
  float elevation_sigma_rad;
  // Greatest range, m.
  float range_max_m;
  // Half width of the soft edge at it, m.
  float range_edge_m;
  // Half width of the window in bearing, rad; pi or more for all around.
  float bearing_half_width_rad;
  // Half width of the window in elevation, rad; pi/2 or more for everything.
  float elevation_half_width_rad;
  // Half width of the soft edges in bearing and elevation, rad.
  float angle_edge_rad;
  // Probability of detection, in [0, 1).
  float probability;
  // False measurements to expect of a scan.
  float clutter_per_scan;
  // Intensity of births of features that stand still, 1/(m rad^2).
  float births_still;
  // Where it sits.
  struct scphd_mounting mounting;
} scphd_sonar_config;

// A vehicle in the plane, and the noise of its odometry. The defaults are those of a wheeled vehicle whose noise nobody has measured:
// 0.02 m/s and 10 %, 0.02 rad/s (or rad) and 10 %, for half a second. Without any noise it is refused.
typedef struct scphd_vehicle {
  // `SCPHD_VEHICLE_CAR`, `SCPHD_VEHICLE_ROBOT` or `SCPHD_VEHICLE_HOLONOMIC`.
  uint32_t kind;
  // Of a car: wheelbase L, m.
  float wheelbase_m;
  // Of a car: offset H of the wheel encoder from the centreline, m.
  float encoder_offset_m;
  // Of a car: how far ahead of the rear axle its pose is, m.
  float pose_forward_m;
  // Of a car: how far left of the centreline its pose is, m.
  float pose_left_m;
  // Standard deviation of the speed, m/s.
  float speed_sigma_mps;
  // The same as a share of the speed; adds in quadrature.
  float speed_sigma_ratio;
  // Standard deviation of a car's steering angle, rad, or of the others' turn rate, rad/s.
  float turn_sigma;
  // The same as a share of it; adds in quadrature.
  float turn_sigma_ratio;
  // How long an error lasts, s. 0: drawn anew in every prediction.
  float noise_interval_s;
} scphd_vehicle;

// What no vehicle does. A prediction beyond it is refused; infinite: no limit.
typedef struct scphd_plausible {
  // Longest step, s.
  float step_max_s;
  // Greatest speed, m/s.
  float speed_max_mps;
  // Greatest turn rate, rad/s.
  float turn_rate_max_radps;
  // Greatest distance of one step, m.
  float jump_max_m;
} scphd_plausible;

// The tuning of a mixture: `Config` of the library, whose documentation says more of each field. Do not fill it in by hand, but by
// `scphd_plane_blind` and its like.
typedef struct scphd_tuning {
  // Particles kept between scans.
  uint32_t particles;
  // Samples of each in a prediction.
  uint32_t samples;
  // `SCPHD_PROPOSAL_...`
  uint32_t proposal;
  // Informed: linearisations, 1 to 16.
  uint32_t informed_rounds;
  // Informed: share of the covariance that is drawn from, 0 to 1.
  float informed_sampled_fraction;
  // Informed: a component speaks for a measurement of which it explains this share.
  float informed_min_responsibility;
  // Resampled where N_eff / N is below.
  float resample_threshold;
  // Components below this weight are dropped.
  float prune_weight;
  // A component is confirmed where it is better known than by so many measurements.
  float confirming_detections;
  // One that leaves the view lighter than this, not confirmed, is forgotten. 0: none is.
  float unconfirmed_weight;
  // Misses take a confirmed component no further down. 0: they do.
  float confirmed_weight;
  // Squared Mahalanobis distance within which components are merged.
  float merge_distance;
  // `SCPHD_EXTRACTION_...`
  uint32_t extraction;
  // Least weight of an estimated feature.
  float extraction_weight;
  // Not 0: births that nothing explains wait for the next scan. For filters of a single sensor.
  uint32_t births_wait;
  // Moving features: standard deviation of a new one's velocity, m/s, along each axis.
  float moving_velocity_sigma_mps;
  // Moving features: power spectral density of their acceleration, m^2/s^3.
  float moving_acceleration_psd;
  // Moving features: mean time until one vanishes, s.
  float moving_lifetime_s;
  // Moving features: one less certain than this, m, is forgotten.
  float moving_spread_max_m;
  // Moving features: least weight of an estimated one.
  float moving_extraction_weight;
  // What no vehicle does.
  struct scphd_plausible plausible;
} scphd_tuning;

// What there is to say of such a filter.
typedef struct scphd_plane_config {
  // `sizeof(scphd_plane_config)`, set by the caller.
  uint32_t struct_size;
  // The vehicle.
  struct scphd_vehicle vehicle;
  // The tuning.
  struct scphd_tuning tuning;
} scphd_plane_config;

// What a prediction did.
typedef struct scphd_predict_report {
  // `sizeof(scphd_predict_report)`, set by the caller.
  uint32_t struct_size;
  // Bits of `SCPHD_HEALTH_...`; 0 is good.
  uint32_t health;
  // Candidates after it.
  uint32_t candidates;
  // Candidates that stayed where they were, for their pose left the range of single precision.
  uint32_t rejected;
  // Predictions refused since the last scan.
  uint32_t refused;
} scphd_predict_report;

// One measurement.
typedef struct scphd_range_bearing {
  // m.
  float range_m;
  // 0 ahead, growing to the left, rad.
  float bearing_rad;
} scphd_range_bearing;

// What a scan of a mixture did.
typedef struct scphd_scan_report {
  // `sizeof(scphd_scan_report)`, set by the caller.
  uint32_t struct_size;
  // Bits of `SCPHD_HEALTH_...`; 0 is good.
  uint32_t health;
  // Measurements in the scan.
  uint32_t measurements;
  // Measurements that could not give birth.
  uint32_t no_birth;
  // Predictions refused since the scan before.
  uint32_t refused;
  // Candidates weighed.
  uint32_t candidates;
  // Most components in view of a candidate.
  uint32_t in_view;
  // Particles that go on.
  uint32_t particles;
  // Whether they were resampled: 0 or 1.
  uint32_t resampled;
  // Components born and kept.
  uint32_t births;
  // Components merged into another.
  uint32_t merged;
  // Components that found no room.
  uint32_t lost;
  // Pages of features in use after the scan, and in all.
  uint32_t pages_used;
  // See `pages_used`.
  uint32_t pages;
  // Pages of moving features in use after the scan, and in all.
  uint32_t moving_pages_used;
  // See `moving_pages_used`.
  uint32_t moving_pages;
  // Effective number of candidates before any resampling.
  float n_eff;
  // Logarithm of the scan's likelihood, up to a constant; minus infinity where no candidate explains it.
  float ln_evidence;
  // Mean squared innovation by its covariance, per dimension; about 1 for a consistent filter, 0 where nothing was detected.
  float innovation;
} scphd_scan_report;

// How a fix is measured.
typedef struct scphd_fix {
  // `sizeof(scphd_fix)`, set by the caller.
  uint32_t struct_size;
  // Standard deviation of its noise, m of a position (along either axis) or a height, rad of a heading.
  float sigma;
  // Squared Mahalanobis distance beyond which it is an outlier; 0: none is.
  float gate;
  // Of a position: how far ahead of the pose the antenna is, m.
  float antenna_forward_m;
  // Of a position: how far left of the pose the antenna is, m.
  float antenna_left_m;
} scphd_fix;

// What a fix did.
typedef struct scphd_fix_report {
  // `sizeof(scphd_fix_report)`, set by the caller.
  uint32_t struct_size;
  // Whether it was taken in: 0 or 1. It is not where it lies beyond the gate.
  uint32_t accepted;
  // Its squared Mahalanobis distance from what the filter expected.
  float distance;
  // Logarithm of its likelihood; 0 where it was not taken in.
  float ln_evidence;
  // Effective number of candidates after it.
  float n_eff;
} scphd_fix_report;

// A pose in the plane and how well it is known.
typedef struct scphd_plane_pose {
  // `sizeof(scphd_plane_pose)`, set by the caller.
  uint32_t struct_size;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // From the x axis towards the y axis, rad.
  float heading_rad;
  // Covariance of (x, y, heading), row after row, in the squares of their units.
  float covariance[9];
} scphd_plane_pose;

// A feature in the plane.
typedef struct scphd_feature {
  // Names it from scan to scan.
  uint32_t label;
  // How many features it stands for; of a joint map, the probability that it is there.
  float weight;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // Covariance: xx, xy, yy, m^2.
  float covariance[3];
} scphd_feature;

// What there is to a map beside the features.
typedef struct scphd_map {
  // `sizeof(scphd_map)`, set by the caller.
  uint32_t struct_size;
  // Features written to the array.
  uint32_t features;
  // Features left out because it was too small.
  uint32_t left_out;
  // The expected number of features.
  float expected_features;
} scphd_map;

// A feature that moves in the plane.
typedef struct scphd_mover {
  // Names it from scan to scan.
  uint32_t label;
  // How many features it stands for.
  float weight;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // Along x, m/s.
  float vx_mps;
  // Along y, m/s.
  float vy_mps;
  // Covariance, its lower triangle row after row: xx; xy, yy; then of vx and of vy with all before them.
  float covariance[10];
} scphd_mover;

// What there is to say of such a filter. Do not fill it in by hand, but by `scphd_joint_defaults`.
typedef struct scphd_joint_config {
  // `sizeof(scphd_joint_config)`, set by the caller.
  uint32_t struct_size;
  // The vehicle.
  struct scphd_vehicle vehicle;
  // A measurement gives birth where nothing else explains at least this share of it.
  float birth_probability_min;
  // Squared Mahalanobis distance beyond which a measurement says nothing of a feature.
  float gate;
  // Mean time that a landmark stays in sight before something hides it, s; infinite: nothing does.
  float visible_s;
  // Mean time that it stays hidden, s.
  float occluded_s;
  // Mean time until it is taken away, s; infinite: never.
  float lifetime_s;
  // Share of the probability of detection that is left behind a nearer detection.
  float occlusion_factor;
  // A feature is dropped below this probability that it is there.
  float least_existence;
  // The same while it was detected less than twice.
  float least_tentative;
  // A feature is part of the estimate from this probability on.
  float extraction_existence;
  // Squared Mahalanobis distance within which two features are one.
  float merge_distance;
  // What no vehicle does.
  struct scphd_plausible plausible;
} scphd_joint_config;

// What a scan of a joint map did.
typedef struct scphd_joint_report {
  // `sizeof(scphd_joint_report)`, set by the caller.
  uint32_t struct_size;
  // Bits of `SCPHD_HEALTH_...`; 0 is good.
  uint32_t health;
  // Measurements in the scan.
  uint32_t measurements;
  // Features in view before it.
  uint32_t in_view;
  // Predictions refused since the scan before.
  uint32_t refused;
  // Features born.
  uint32_t births;
  // Features dropped.
  uint32_t dropped;
  // Features that turned out to be another one.
  uint32_t merged;
  // Features for which there was no room.
  uint32_t lost;
  // Features after the scan.
  uint32_t features;
  // Logarithm of the scan's likelihood, up to a constant.
  float ln_evidence;
  // As of `scphd_scan_report`.
  float innovation;
} scphd_joint_report;

// What there is to say of such a filter.
typedef struct scphd_water_config {
  // `sizeof(scphd_water_config)`, set by the caller.
  uint32_t struct_size;
  // Standard deviation of the angular acceleration about the vertical, rad/s^2.
  float yaw_acceleration_sigma_radps2;
  // How long an error of the velocity lasts, s. 0: drawn anew in every prediction.
  float velocity_interval_s;
  // The tuning.
  struct scphd_tuning tuning;
} scphd_water_config;

// What moves the vehicle in one step.
typedef struct scphd_water_control {
  // `sizeof(scphd_water_control)`, set by the caller.
  uint32_t struct_size;
  // Velocity along the vehicle's own axes, x ahead, y to the left, z upwards, m/s.
  float velocity_mps[3];
  // Its covariance: xx, xy, yy, xz, yz, zz, m^2/s^2.
  float velocity_covariance[6];
  // Roll at the end of the step, rad.
  float roll_rad;
  // Pitch at the end of the step, rad.
  float pitch_rad;
  // Mean yaw rate during the step, rad/s.
  float yaw_rate_radps;
  // Its standard deviation, rad/s. 0: there is no gyroscope.
  float yaw_rate_sigma_radps;
  // Height at the end of the step, m, upwards: minus the depth.
  float z_m;
  // Its standard deviation, m. 0: there is no pressure sensor.
  float z_sigma_m;
} scphd_water_control;

// One measurement.
typedef struct scphd_sonar {
  // m.
  float range_m;
  // 0 ahead, growing to the left, rad.
  float bearing_rad;
  // 0 level, growing upwards, rad.
  float elevation_rad;
} scphd_sonar;

// A pose under water and how well it is known.
typedef struct scphd_water_pose {
  // `sizeof(scphd_water_pose)`, set by the caller.
  uint32_t struct_size;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // z, m, upwards: minus the depth.
  float z_m;
  // From the x axis towards the y axis, rad.
  float yaw_rad;
  // rad/s.
  float yaw_rate_radps;
  // As the last control has it, rad.
  float roll_rad;
  // As the last control has it, rad.
  float pitch_rad;
  // Covariance of (x, y, z, yaw, yaw rate), row after row, in the squares of their units.
  float covariance[25];
} scphd_water_pose;

// A feature in space.
typedef struct scphd_feature_3d {
  // Names it from scan to scan.
  uint32_t label;
  // How many features it stands for.
  float weight;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // z, m.
  float z_m;
  // Covariance: xx, xy, yy, xz, yz, zz, m^2.
  float covariance[6];
} scphd_feature_3d;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version that the library was built with; `SCPHD_ABI_VERSION` is that of the header.
uint32_t scphd_abi_version(void);

// What a status means, in one line of English; any number may be given. The text lasts as long as the program.
const char *scphd_error_text(int32_t status);

// What the memory of every set must be aligned to, bytes: `SCPHD_ALIGNMENT`.
size_t scphd_memory_alignment(void);

// Ends what runs in this memory, whatever it is, and if nothing does: it can be started anew. Handles to it are refused from then on.
scphd_status scphd_release(void *memory,
                           size_t size_bytes);

// How much memory a set needs, bytes: `SCPHD_SIZE_...` of its name. 0 for a set that is not known.
size_t scphd_memory_size(uint32_t set);

// The name of the lowest of some conditions, as in docs/health.md: ask for one bit after the other. GOOD where there is none. The text
// lasts as long as the program.
const char *scphd_health_text(uint32_t health);

// A sensor that sees all around, as far as this, m, and with this probability of detection, in [0, 1): one false measurement a scan,
// one in ten scans of a feature that is new, none that moves, seated where the pose is. The standard deviations of its noise are left 0,
// which is out of range: set them.
scphd_status scphd_range_bearing_defaults(scphd_range_bearing_config *config,
                                          float range_max_m,
                                          float probability);

// Starts a detector in this memory: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of `SCPHD_SET_RANGE_BEARING_...`. The reason may be
// null. Writes the handle to `detector`, or null.
scphd_status scphd_range_bearing_start(uint32_t abi_version,
                                       uint32_t set,
                                       void *memory,
                                       size_t size_bytes,
                                       const scphd_range_bearing_config *config,
                                       scphd_reason *reason,
                                       scphd_range_bearing_detector **detector);

// A sensor that sees all around, as far as this, m, and with this probability of detection, in [0, 1): one false measurement a scan,
// four rings of 24 births from a tenth of the range on, seated where the pose is. The standard deviation of its noise is left 0, which is
// out of range: set it.
scphd_status scphd_bearing_defaults(scphd_bearing_config *config,
                                    float range_max_m,
                                    float probability);

// Starts a detector in this memory: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of `SCPHD_SET_BEARING_...`. The reason may be null.
// Writes the handle to `detector`, or null.
scphd_status scphd_bearing_start(uint32_t abi_version,
                                 uint32_t set,
                                 void *memory,
                                 size_t size_bytes,
                                 const scphd_bearing_config *config,
                                 scphd_reason *reason,
                                 scphd_bearing_detector **detector);

// A sonar that sees everything as far as this, m, with this probability of detection, in [0, 1): one false measurement a scan, one in ten
// scans of a feature that is new, seated where the pose is. The standard deviations of its noise are left 0, which is out of range:
// set them.
scphd_status scphd_sonar_defaults(scphd_sonar_config *config,
                                  float range_max_m,
                                  float probability);

// Starts a detector in this memory: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of `SCPHD_SET_SONAR_...`. The reason may be null.
// Writes the handle to `detector`, or null.
scphd_status scphd_sonar_start(uint32_t abi_version,
                               uint32_t set,
                               void *memory,
                               size_t size_bytes,
                               const scphd_sonar_config *config,
                               scphd_reason *reason,
                               scphd_sonar_detector **detector);

// Fills in a configuration, but for its size: many particles, each with so many samples of the motion that the scan chooses among. For
// sensors whose scan leaves several places open. The vehicle is a robot without noise: set what it is.
scphd_status scphd_plane_blind(scphd_plane_config *config,
                               uint32_t particles,
                               uint32_t samples);

// Fills in a configuration, but for its size: few particles that take the scan in before they are drawn. For sensors whose scan tells
// where the vehicle is among its features. The vehicle is a robot without noise: set what it is.
scphd_status scphd_plane_informed(scphd_plane_config *config,
                                  uint32_t particles);

// Starts a filter in this memory, which is zero or was released: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of
// `SCPHD_SET_PLANE_...`. The reason may be null. Writes the handle to `filter`, or null. Reset it to a pose next.
scphd_status scphd_plane_start(uint32_t abi_version,
                               uint32_t set,
                               void *memory,
                               size_t size_bytes,
                               const scphd_plane_config *config,
                               scphd_reason *reason,
                               scphd_plane **filter);

// Goes on with what the same build of this library has left in this memory: after a reset of the processor that kept it, or in a copy of
// it. The configuration may be another, but for particles, samples and proposal. What is found is checked; it is no checksum, and
// memory that may have been damaged needs one.
scphd_status scphd_plane_resume(uint32_t abi_version,
                                uint32_t set,
                                void *memory,
                                size_t size_bytes,
                                const scphd_plane_config *config,
                                scphd_reason *reason,
                                scphd_plane **filter);

// Puts the vehicle to a pose, with an empty map, and begins the random stream of a seed.
scphd_status scphd_plane_reset(scphd_plane *filter, float x_m, float y_m, float heading_rad, uint64_t seed);

// Moves a car for `dt_s` seconds: speed of its encoder's wheel, steering angle to the left. The report may be null. Where the control is
// refused, its time has passed all the same, and the next report says so.
scphd_status scphd_plane_predict_car(scphd_plane *filter,
                                     float speed_mps,
                                     float steering_rad,
                                     float dt_s,
                                     scphd_predict_report *report);

// Moves a robot for `dt_s` seconds: speed, turn rate to the left. As `scphd_plane_predict_car`.
scphd_status scphd_plane_predict_robot(scphd_plane *filter,
                                       float speed_mps,
                                       float rate_radps,
                                       float dt_s,
                                       scphd_predict_report *report);

// Moves a vehicle that moves sideways too for `dt_s` seconds: speeds ahead and to the left, turn rate to the left. As
// `scphd_plane_predict_car`.
scphd_status scphd_plane_predict_holonomic(scphd_plane *filter,
                                           float forward_mps,
                                           float left_mps,
                                           float rate_radps,
                                           float dt_s,
                                           scphd_predict_report *report);

// Takes in a scan of range and bearing. The report may be null; so may the measurements, where there are none.
scphd_status scphd_plane_scan_range_bearing(scphd_plane *filter,
                                            scphd_range_bearing_detector *detector,
                                            const scphd_range_bearing *measurements,
                                            size_t count,
                                            scphd_scan_report *report);

// Takes in a scan of bearings, rad, 0 ahead, growing to the left. As `scphd_plane_scan_range_bearing`.
scphd_status scphd_plane_scan_bearing(scphd_plane *filter,
                                      scphd_bearing_detector *detector,
                                      const float *bearings_rad,
                                      size_t count,
                                      scphd_scan_report *report);

// Takes in a measured position, between any two steps. The report may be null.
scphd_status scphd_plane_observe_position(scphd_plane *filter,
                                          const scphd_fix *fix,
                                          float x_m,
                                          float y_m,
                                          scphd_fix_report *report);

// Takes in a measured heading, from the x axis towards the y axis, between any two steps. The report may be null.
scphd_status scphd_plane_observe_heading(scphd_plane *filter,
                                         const scphd_fix *fix,
                                         float heading_rad,
                                         scphd_fix_report *report);

// Where the vehicle is.
scphd_status scphd_plane_estimate_pose(scphd_plane *filter, scphd_plane_pose *pose);

// Writes the features that stand still to an array of so many; what does not fit is counted. An array of none may be null.
scphd_status scphd_plane_estimate_map(scphd_plane *filter,
                                      scphd_feature *features,
                                      size_t capacity,
                                      scphd_map *map);

// Writes the features that move to an array of so many, where they are by now. As `scphd_plane_estimate_map`.
scphd_status scphd_plane_estimate_movers(scphd_plane *filter,
                                         scphd_mover *movers,
                                         size_t capacity,
                                         scphd_map *map);

// A hash of all that the filter knows, to the last bit: the same inputs give the same on every machine.
scphd_status scphd_plane_digest(scphd_plane *filter, uint64_t *digest);

// Fills in a configuration, but for its size. The vehicle is a robot without noise: set what it is.
scphd_status scphd_joint_defaults(scphd_joint_config *config);

// Starts a filter in this memory, which is zero or was released: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of
// `SCPHD_SET_JOINT_...`. The reason may be null. Writes the handle to `filter`, or null. Reset it to a pose next.
scphd_status scphd_joint_start(uint32_t abi_version,
                               uint32_t set,
                               void *memory,
                               size_t size_bytes,
                               const scphd_joint_config *config,
                               scphd_reason *reason,
                               scphd_joint **filter);

// Goes on with what the same build of this library has left in this memory, as `scphd_plane_resume`; but what is found is taken as it is.
scphd_status scphd_joint_resume(uint32_t abi_version,
                                uint32_t set,
                                void *memory,
                                size_t size_bytes,
                                const scphd_joint_config *config,
                                scphd_reason *reason,
                                scphd_joint **filter);

// Puts the vehicle to a pose, certain of it, with an empty map.
scphd_status scphd_joint_reset(scphd_joint *filter, float x_m, float y_m, float heading_rad);

// As `scphd_plane_predict_car`.
scphd_status scphd_joint_predict_car(scphd_joint *filter,
                                     float speed_mps,
                                     float steering_rad,
                                     float dt_s,
                                     scphd_predict_report *report);

// As `scphd_plane_predict_robot`.
scphd_status scphd_joint_predict_robot(scphd_joint *filter,
                                       float speed_mps,
                                       float rate_radps,
                                       float dt_s,
                                       scphd_predict_report *report);

// Moves a vehicle that moves sideways too for `dt_s` seconds: speeds ahead and to the left, turn rate to the left. As
// `scphd_plane_predict_car`.
scphd_status scphd_joint_predict_holonomic(scphd_joint *filter,
                                           float forward_mps,
                                           float left_mps,
                                           float rate_radps,
                                           float dt_s,
                                           scphd_predict_report *report);

// Takes in a scan of range and bearing. The report may be null; so may the measurements, where there are none.
scphd_status scphd_joint_scan_range_bearing(scphd_joint *filter,
                                            scphd_range_bearing_detector *detector,
                                            const scphd_range_bearing *measurements,
                                            size_t count,
                                            scphd_joint_report *report);

// As `scphd_plane_observe_position`.
scphd_status scphd_joint_observe_position(scphd_joint *filter,
                                          const scphd_fix *fix,
                                          float x_m,
                                          float y_m,
                                          scphd_fix_report *report);

// As `scphd_plane_observe_heading`.
scphd_status scphd_joint_observe_heading(scphd_joint *filter,
                                         const scphd_fix *fix,
                                         float heading_rad,
                                         scphd_fix_report *report);

// Where the vehicle is.
scphd_status scphd_joint_estimate_pose(scphd_joint *filter, scphd_plane_pose *pose);

// Writes the features to an array of so many; what does not fit is counted. An array of none may be null.
scphd_status scphd_joint_estimate_map(scphd_joint *filter,
                                      scphd_feature *features,
                                      size_t capacity,
                                      scphd_map *map);

// As `scphd_plane_digest`.
scphd_status scphd_joint_digest(scphd_joint *filter, uint64_t *digest);

// Fills in a configuration, but for its size: few particles that take the scan in before they are drawn. The yaw's acceleration is left
// 0, which is out of range: set it.
scphd_status scphd_water_informed(scphd_water_config *config,
                                  uint32_t particles);

// Starts a filter in this memory, which is zero or was released: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of
// `SCPHD_SET_WATER_...`. The reason may be null. Writes the handle to `filter`, or null. Reset it to a pose next.
scphd_status scphd_water_start(uint32_t abi_version,
                               uint32_t set,
                               void *memory,
                               size_t size_bytes,
                               const scphd_water_config *config,
                               scphd_reason *reason,
                               scphd_water **filter);

// Goes on with what the same build of this library has left in this memory, as `scphd_plane_resume`.
scphd_status scphd_water_resume(uint32_t abi_version,
                                uint32_t set,
                                void *memory,
                                size_t size_bytes,
                                const scphd_water_config *config,
                                scphd_reason *reason,
                                scphd_water **filter);

// Puts the vehicle to a position and a yaw, level and at rest, with an empty map, and begins the random stream of a seed.
scphd_status scphd_water_reset(scphd_water *filter,
                               float x_m,
                               float y_m,
                               float z_m,
                               float yaw_rad,
                               uint64_t seed);

// Moves the vehicle for `dt_s` seconds. The report may be null. A refused control is as for `scphd_plane_predict_car`.
scphd_status scphd_water_predict(scphd_water *filter,
                                 const scphd_water_control *control,
                                 float dt_s,
                                 scphd_predict_report *report);

// Takes in a scan of range, bearing and elevation. The report may be null; so may the measurements, where there are none.
scphd_status scphd_water_scan_sonar(scphd_water *filter,
                                    scphd_sonar_detector *detector,
                                    const scphd_sonar *measurements,
                                    size_t count,
                                    scphd_scan_report *report);

// Takes in a measured height, m, upwards: minus the depth. The report may be null.
scphd_status scphd_water_observe_height(scphd_water *filter,
                                        const scphd_fix *fix,
                                        float z_m,
                                        scphd_fix_report *report);

// Takes in a measured yaw, from the x axis towards the y axis. The report may be null.
scphd_status scphd_water_observe_heading(scphd_water *filter,
                                         const scphd_fix *fix,
                                         float yaw_rad,
                                         scphd_fix_report *report);

// Where the vehicle is.
scphd_status scphd_water_estimate_pose(scphd_water *filter, scphd_water_pose *pose);

// Writes the features to an array of so many; what does not fit is counted. An array of none may be null.
scphd_status scphd_water_estimate_map(scphd_water *filter,
                                      scphd_feature_3d *features,
                                      size_t capacity,
                                      scphd_map *map);

// As `scphd_plane_digest`.
scphd_status scphd_water_digest(scphd_water *filter, uint64_t *digest);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SCPHD_H */
