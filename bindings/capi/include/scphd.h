/*
 * scphd: single-cluster PHD SLAM in fixed memory. Made from the crate scphd-capi by cbindgen; do not edit.
 *
 * The library keeps nothing: a filter and its description live in memory of the user's, SCPHD_SIZE_... bytes, aligned to
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

/* Joint map: 40 features, scans of 32 measurements. */
#define SCPHD_SIZE_JOINT_40 23552

/* Joint map: 100 features, scans of 32 measurements. */
#define SCPHD_SIZE_JOINT_100 99328

/* Joint map: 60 static and 16 moving features, scans of 32 measurements. */
#define SCPHD_SIZE_JOINT_60_MOVERS 44032

/* Joint map: 100 static and 32 moving features, scans of 32 measurements. */
#define SCPHD_SIZE_JOINT_100_MOVERS 102400

/* Joint map: 40 static and 16 moving features, and an archive of 1000 distant features; scans of 32 measurements. */
#define SCPHD_SIZE_JOINT_40_ARCHIVE 368640

/* Joint map that estimates the odometry error: 60 features, scans of 32 measurements. */
#define SCPHD_SIZE_JOINT_60_LEARNING 44032

/* Joint map with eight hypotheses of data association, each with 24 static and 8 moving features; scans of 16 measurements. */
#define SCPHD_SIZE_JOINT_24_HYPOTHESES 65536

/* Mixture: 32 particles of two samples, 320 pages of features, 32 to a map, 256 in view; 128 pages of moving ones; scans of 128 measurements, of range and bearing or of bearings alone. */
#define SCPHD_SIZE_MIXTURE_32X2 206848

/* Mixture: four informed particles, 128 pages of features, 32 to a map, 256 in view; no moving ones; scans of 64 measurements. */
#define SCPHD_SIZE_MIXTURE_INFORMED_4 55296

/* As the previous one, with 64 pages of moving features, 16 to a map, 128 in view. */
#define SCPHD_SIZE_MIXTURE_INFORMED_4_MOVING 102400

/* Mixture under water: 16 informed particles, 160 pages of features, 24 to a map, 256 in view; none that move. */
#define SCPHD_SIZE_WATER_INFORMED_16 94208

/* Detector of range, bearing and elevation: scans of 64 measurements. */
#define SCPHD_SIZE_SONAR_64 1792

/* A description of a vehicle. */
#define SCPHD_SIZE_DESCRIPTION 656

/*
 * Settings of a description, for scphd_description_set: what each is, its unit, and the numbers that it may have.
 */

/* How the vehicle moves. */
#define SCPHD_VEHICLE_KIND 1
#define SCPHD_VEHICLE_KIND_ACKERMANN 0
#define SCPHD_VEHICLE_KIND_UNICYCLE 1
#define SCPHD_VEHICLE_KIND_UNICYCLE_EULER 2
#define SCPHD_VEHICLE_KIND_HOLONOMIC 3

/* Wheelbase L of a car. In m. Must be finite and above 0. */
#define SCPHD_VEHICLE_WHEELBASE_M 2

/* Offset H of the wheel encoder of a car from the centreline. In m. Must be finite. */
#define SCPHD_VEHICLE_ENCODER_OFFSET_M 3

/* Distance of the pose of a car ahead of the rear axle. In m. Must be finite. */
#define SCPHD_VEHICLE_SENSOR_FORWARD_M 4

/* Distance of the pose of a car to the left of the centreline. In m. Must be finite. */
#define SCPHD_VEHICLE_SENSOR_LEFT_M 5

/* Standard deviation of the speed. In m/s. Must be finite and at least 0. */
#define SCPHD_NOISE_SPEED_SIGMA_MPS 6

/* Standard deviation of the speed divided by the speed; adds in quadrature. Must be finite and at least 0. */
#define SCPHD_NOISE_SPEED_SIGMA_RATIO 7

/* Standard deviation of the turn rate, or of a car's steering angle, rad. In rad/s. Must be finite and at least 0. */
#define SCPHD_NOISE_TURN_SIGMA 8

/* Standard deviation of the turn rate or steering angle divided by its value; adds in quadrature. Must be finite and at least 0. */
#define SCPHD_NOISE_TURN_SIGMA_RATIO 9

/* Correlation time of the errors; 0: independent in every prediction. In s. Must be finite and at least 0. */
#define SCPHD_NOISE_INTERVAL_S 10

/* The filter. A change sets its defaults. */
#define SCPHD_FILTER 11
#define SCPHD_FILTER_MIXTURE 0
#define SCPHD_FILTER_JOINT 1

/* Number of particles between scans. Must be between 1 and 65535. */
#define SCPHD_MIXTURE_PARTICLES 12

/* Number of samples of each particle in a prediction. Must be between 1 and 65535. */
#define SCPHD_MIXTURE_SAMPLES 13

/* Proposal density: the motion model, or a Gaussian that includes the scan. */
#define SCPHD_MIXTURE_PROPOSAL 14
#define SCPHD_MIXTURE_PROPOSAL_BLIND 0
#define SCPHD_MIXTURE_PROPOSAL_INFORMED 1

/* Informed proposal: maximum number of linearisations. Must be between 1 and 16. */
#define SCPHD_MIXTURE_INFORMED_ROUNDS 15

/* Informed proposal: share of its covariance that is sampled. Must be between 0 and 1. */
#define SCPHD_MIXTURE_INFORMED_SAMPLED_FRACTION 16

/* Informed proposal: least association probability of a measurement that is used. Must be above 0 and below 1. */
#define SCPHD_MIXTURE_INFORMED_MIN_RESPONSIBILITY 17

/* Particles are resampled if N_eff / N is below this value. Must be between 0 and 1. */
#define SCPHD_MIXTURE_RESAMPLE_THRESHOLD 18

/* Components with a smaller weight are removed. Must be above 0 and below 1. */
#define SCPHD_MIXTURE_PRUNE_WEIGHT 19

/* Number of measurements that confirm a component, judged by its covariance; at least 1. Must be finite and at least 0. */
#define SCPHD_MIXTURE_CONFIRMING_DETECTIONS 20

/* An unconfirmed component with a smaller weight is removed when it leaves the view; 0: none is. Must be between 0 and 1. */
#define SCPHD_MIXTURE_UNCONFIRMED_WEIGHT 21

/* Least weight of a confirmed component after misses; 0: no limit. Must be between 0 and 1. */
#define SCPHD_MIXTURE_CONFIRMED_WEIGHT 22

/* Squared Mahalanobis distance within which components are merged. Must be finite and at least 0. */
#define SCPHD_MIXTURE_MERGE_DISTANCE 23

/* Least weight of an estimated feature. Must be between 0 and 1. */
#define SCPHD_MIXTURE_EXTRACTION_WEIGHT 24

/* Terms of the update below this share of clutter and births are left out; at most prune_weight. Must be above 0 and below 1. */
#define SCPHD_MIXTURE_NEGLIGIBLE 25

/* Maximum number of components in view after pruning and merging. Must be finite and at least 1. */
#define SCPHD_MIXTURE_MAX_COMPONENTS 26

/* Selection of the components that are estimated features. */
#define SCPHD_MIXTURE_EXTRACTION 27
#define SCPHD_MIXTURE_EXTRACTION_HEAVIEST 0
#define SCPHD_MIXTURE_EXTRACTION_PEAKS 1
#define SCPHD_MIXTURE_EXTRACTION_CONFIRMED 2

/* Whether unexplained births wait for the next scan. */
#define SCPHD_MIXTURE_BIRTHS_WAIT 28
#define SCPHD_MIXTURE_BIRTHS_WAIT_NO 0
#define SCPHD_MIXTURE_BIRTHS_WAIT_YES 1

/* Least probability of a measurement to be from a new feature for it to start one. Must be between 0 and 1. */
#define SCPHD_JOINT_BIRTH_PROBABILITY_MIN 29

/* Gate of the association: greatest squared Mahalanobis distance of a measurement. Must be finite and at least 0. */
#define SCPHD_JOINT_GATE 30

/* Factor on the probability of detection behind a nearer detection. Must be between 0 and 1. */
#define SCPHD_JOINT_OCCLUSION_FACTOR 31

/* A feature with a smaller existence probability is removed. Must be between 0 and 1. */
#define SCPHD_JOINT_LEAST_EXISTENCE 32

/* The same for a feature that was detected less than twice. Must be between 0 and 1. */
#define SCPHD_JOINT_LEAST_TENTATIVE 33

/* Least existence probability of an estimated feature. Must be between 0 and 1. */
#define SCPHD_JOINT_EXTRACTION_EXISTENCE 34

/* Squared Mahalanobis distance within which two features are merged. Must be finite and at least 0. */
#define SCPHD_JOINT_MERGE_DISTANCE 35

/* Mean time until a visible landmark is occluded; infinite: never. In s. Must be above 0, or infinite. */
#define SCPHD_JOINT_VISIBLE_S 36

/* Mean time of an occlusion. In s. Must be above 0, or infinite. */
#define SCPHD_JOINT_OCCLUDED_S 37

/* Mean time until a landmark is removed; infinite: never. In s. Must be above 0, or infinite. */
#define SCPHD_JOINT_LIFETIME_S 38

/* Whether moving objects are tracked. */
#define SCPHD_JOINT_MOVERS 39
#define SCPHD_JOINT_MOVERS_NO 0
#define SCPHD_JOINT_MOVERS_YES 1

/* Whether systematic errors of the odometry are estimated. */
#define SCPHD_JOINT_ODOMETRY 40
#define SCPHD_JOINT_ODOMETRY_NO 0
#define SCPHD_JOINT_ODOMETRY_YES 1

/* Whether distant features are moved to an archive of submaps. */
#define SCPHD_JOINT_ARCHIVE 41
#define SCPHD_JOINT_ARCHIVE_NO 0
#define SCPHD_JOINT_ARCHIVE_YES 1

/* Whether there are several hypotheses of data association. */
#define SCPHD_JOINT_HYPOTHESES 42
#define SCPHD_JOINT_HYPOTHESES_NO 0
#define SCPHD_JOINT_HYPOTHESES_YES 1

/* Greatest range of all sensors. In m. Must be finite and above 0. */
#define SCPHD_JOINT_ARCHIVE_REACH_M 43

/* Standard deviation of the scale error of the speed. Must be finite and at least 0. */
#define SCPHD_JOINT_ODOMETRY_SPEED_SCALE 44

/* Standard deviation of the scale error of the turn rate or steering angle. Must be finite and at least 0. */
#define SCPHD_JOINT_ODOMETRY_TURN_SCALE 45

/* Standard deviation of the offset of the turn rate, or of a car's steering angle, rad. In rad/s. Must be finite and at least 0. */
#define SCPHD_JOINT_ODOMETRY_TURN_OFFSET 46

/* Time in which the errors change by their standard deviations (random walk); infinite: they are constant. In s. Must be above 0, or infinite. */
#define SCPHD_JOINT_ODOMETRY_LASTS_S 47

/* Greatest number of hypotheses; the memory may have room for fewer. Must be between 1 and 16. */
#define SCPHD_JOINT_HYPOTHESES_MOST 48

/* Two hypotheses are joined if their poses are within this many standard deviations. Must be finite and at least 0. */
#define SCPHD_JOINT_HYPOTHESES_JOINED_SIGMAS 49

/* A hypothesis is not made if its weight, divided by that of the likeliest, is below this. Must be between 0 and 1. */
#define SCPHD_JOINT_HYPOTHESES_LEAST_RATIO 50

/* A hypothesis is dropped after a scan if its probability is below this. Must be between 0 and 1. */
#define SCPHD_JOINT_HYPOTHESES_LEAST_SHARE 51

/* Moving features: initial standard deviation of the velocity, along each axis. In m/s. Must be between 0.000001 and 1000000. */
#define SCPHD_MOVING_VELOCITY_SIGMA_MPS 52

/* Moving features: power spectral density of the acceleration. In m^2/s^3. Must be finite and at least 0. */
#define SCPHD_MOVING_ACCELERATION_PSD 53

/* Moving features: mean lifetime. In s. Must be above 0, or infinite. */
#define SCPHD_MOVING_LIFETIME_S 54

/* Moving features: one with a greater standard deviation of the position is removed. In m. Must be finite and above 0. */
#define SCPHD_MOVING_SPREAD_MAX_M 55

/* Moving features: least weight of an estimated one. Must be between 0 and 1. */
#define SCPHD_MOVING_EXTRACTION_WEIGHT 56

/* Greatest time step. A longer prediction is refused; infinite: no limit. In s. Must be above 0, or infinite. */
#define SCPHD_PLAUSIBLE_STEP_MAX_S 57

/* Greatest speed. A faster prediction is refused; infinite: no limit. In m/s. Must be above 0, or infinite. */
#define SCPHD_PLAUSIBLE_SPEED_MAX_MPS 58

/* Greatest turn rate. A faster prediction is refused; infinite: no limit. In rad/s. Must be above 0, or infinite. */
#define SCPHD_PLAUSIBLE_TURN_RATE_MAX_RADPS 59

/* Greatest distance of a step. A longer prediction is refused; infinite: no limit. In m. Must be above 0, or infinite. */
#define SCPHD_PLAUSIBLE_JUMP_MAX_M 60

/* Whether the position is measured. */
#define SCPHD_POSITION 61
#define SCPHD_POSITION_NO 0
#define SCPHD_POSITION_YES 1

/* Standard deviation of a measured position. In m. Must be between 0.000001 and 1000000. */
#define SCPHD_POSITION_SIGMA 62

/* Distance of the antenna ahead of the pose. In m. Must be finite. */
#define SCPHD_POSITION_FORWARD_M 63

/* Distance of the antenna to the left of the pose. In m. Must be finite. */
#define SCPHD_POSITION_LEFT_M 64

/* Squared Mahalanobis distance beyond which a measurement is an outlier; infinite: none is. Must be above 0, or infinite. */
#define SCPHD_POSITION_GATE 65

/* Whether the filter is moved if consecutive outliers agree with each other. */
#define SCPHD_POSITION_WATCH 66
#define SCPHD_POSITION_WATCH_NO 0
#define SCPHD_POSITION_WATCH_YES 1

/* Time from the first outlier until the filter is moved; infinite: never. In s. Must be at least 0, or infinite. */
#define SCPHD_POSITION_WATCH_PATIENCE_S 67

/* Least number of consecutive outliers. Must be between 3 and 1000. */
#define SCPHD_POSITION_WATCH_FEWEST 68

/* Whether the heading is measured. */
#define SCPHD_HEADING 69
#define SCPHD_HEADING_NO 0
#define SCPHD_HEADING_YES 1

/* Standard deviation of a measured heading. In rad. Must be between 0.000001 and 1000000. */
#define SCPHD_HEADING_SIGMA 70

/* Squared Mahalanobis distance beyond which a measurement is an outlier; infinite: none is. Must be above 0, or infinite. */
#define SCPHD_HEADING_GATE 71

/* Whether the filter is moved if consecutive outliers agree with each other. */
#define SCPHD_HEADING_WATCH 72
#define SCPHD_HEADING_WATCH_NO 0
#define SCPHD_HEADING_WATCH_YES 1

/* Time from the first outlier until the filter is moved; infinite: never. In s. Must be at least 0, or infinite. */
#define SCPHD_HEADING_WATCH_PATIENCE_S 73

/* Least number of consecutive outliers. Must be between 3 and 1000. */
#define SCPHD_HEADING_WATCH_FEWEST 74

/* Initial x. In m. Must be finite. */
#define SCPHD_START_X_M 75

/* Initial y. In m. Must be finite. */
#define SCPHD_START_Y_M 76

/* Initial heading, counterclockwise from the x axis. In rad. Must be finite. */
#define SCPHD_START_HEADING_RAD 77

/* Standard deviation of the initial position; 0 together with the heading's: the pose is certain. In m. Must be finite and at least 0. */
#define SCPHD_START_POSITION_SIGMA_M 78

/* Standard deviation of the initial heading. In rad. Must be finite and at least 0. */
#define SCPHD_START_HEADING_SIGMA_RAD 79

/* Seed of the random numbers of a mixture. Must be between 0 and 16777216. */
#define SCPHD_START_SEED 80

/* Measurement of the sensor. A change from none sets its defaults. */
#define SCPHD_SENSOR_MODEL 81
#define SCPHD_SENSOR_MODEL_NONE 0
#define SCPHD_SENSOR_MODEL_RANGE_BEARING 1
#define SCPHD_SENSOR_MODEL_BEARING 2

/* Standard deviation of the range. In m. Must be between 0.000001 and 1000000. */
#define SCPHD_SENSOR_RANGE_SIGMA_M 82

/* Standard deviation of the range divided by the range; adds in quadrature. Must be between 0 and 1. */
#define SCPHD_SENSOR_RANGE_SIGMA_RATIO 83

/* Standard deviation of the bearing. In rad. Must be between 0.000001 and 1000000. */
#define SCPHD_SENSOR_BEARING_SIGMA_RAD 84

/* Least range of the view. In m. Must be finite and at least 0. */
#define SCPHD_SENSOR_RANGE_MIN_M 85

/* Greatest range of the view. In m. Must be finite and above 0. */
#define SCPHD_SENSOR_RANGE_MAX_M 86

/* Half width of the gradual edge at both ranges. In m. Must be finite and at least 0. */
#define SCPHD_SENSOR_RANGE_EDGE_M 87

/* Centre of the view. In rad. Must be finite. */
#define SCPHD_SENSOR_BEARING_CENTER_RAD 88

/* Half width of the view; pi or more for a full circle. In rad. Must be finite and above 0. */
#define SCPHD_SENSOR_BEARING_HALF_WIDTH_RAD 89

/* Half width of the gradual edge at both sides. In rad. Must be finite and at least 0. */
#define SCPHD_SENSOR_BEARING_EDGE_RAD 90

/* Probability of detection at range zero. Must be at least 0 and below 1. */
#define SCPHD_SENSOR_PROBABILITY_NEAR 91

/* Probability of detection at the greatest range. Must be at least 0 and below 1. */
#define SCPHD_SENSOR_PROBABILITY_FAR 92

/* Expected number of false measurements in a scan. Must be between 0 and 1000000000. */
#define SCPHD_SENSOR_CLUTTER_PER_SCAN 93

/* Birth intensity of static features. In 1/(m rad). Must be finite and at least 0. */
#define SCPHD_SENSOR_BIRTHS_STILL 94

/* Birth intensity of moving features. In 1/(m rad). Must be finite and at least 0. */
#define SCPHD_SENSOR_BIRTHS_MOVING 95

/* Bearing-only sensor: range of the nearest births. In m. Must be finite and above 0. */
#define SCPHD_SENSOR_BIRTHS_NEAREST_M 96

/* Bearing-only sensor: range of the farthest births. In m. Must be finite and above 0. */
#define SCPHD_SENSOR_BIRTHS_FARTHEST_M 97

/* Bearing-only sensor: number of ranges with births. Must be between 2 and 65535. */
#define SCPHD_SENSOR_BIRTHS_RINGS 98

/* Bearing-only sensor: number of births at each range. Must be between 1 and 65535. */
#define SCPHD_SENSOR_BIRTHS_SECTORS 99

/* Bearing-only sensor: weight of each birth. Must be finite and at least 0. */
#define SCPHD_SENSOR_BIRTHS_WEIGHT 100

/* Distance of the sensor ahead of the pose. In m. Must be finite. */
#define SCPHD_SENSOR_FORWARD_M 101

/* Distance of the sensor to the left of the pose. In m. Must be finite. */
#define SCPHD_SENSOR_LEFT_M 102

/* Direction of the sensor, counterclockwise from that of the vehicle. In rad. Must be finite. */
#define SCPHD_SENSOR_YAW_RAD 103


// The version of this interface. It changes whenever a program that was compiled with another header would not work.
#define SCPHD_ABI_VERSION 5

// No candidate explains the scan: the vehicle is lost, or clutter and birth intensities are both zero.
#define SCPHD_HEALTH_UNEXPLAINED_SCAN 1

// The estimated pose depends on a single sample.
#define SCPHD_HEALTH_DEGENERATE 2

// A map had so little memory that components above the pruning threshold were removed.
#define SCPHD_HEALTH_PRUNING_TIGHTENED 4

// A map remains as predicted because of too little memory.
#define SCPHD_HEALTH_MAP_NOT_UPDATED 8

// Components were discarded because of too little memory.
#define SCPHD_HEALTH_COMPONENTS_LOST 16

// Rounding errors made a covariance indefinite; it was repaired.
#define SCPHD_HEALTH_COVARIANCE_REPAIRED 32

// A predicted pose was out of the range of single precision; it was not changed.
#define SCPHD_HEALTH_POSE_REJECTED 64

// The mean squared innovation is more than twice the expected value: the noise is set too low, or the estimated pose is wrong.
#define SCPHD_HEALTH_INNOVATION_HIGH 128

// Predictions since the last scan were refused.
#define SCPHD_HEALTH_PREDICTION_REFUSED 256

// Known landmarks are missed, and other measurements appear: the odds are a hundred to one that the estimated pose is wrong.
#define SCPHD_HEALTH_DIVERGENCE_SUSPECTED 512

// As before, with odds of ten thousand to one. It stays set until the pose is set or made uncertain, or known landmarks are
// detected again.
#define SCPHD_HEALTH_LOST 1024

// There has been no scan for eight times the usual interval, and for at least a second.
#define SCPHD_HEALTH_INPUT_LOST 2048

// Memory scrubbing found and repaired damage.
#define SCPHD_HEALTH_STATE_REPAIRED 4096

// Far more measurements than usual come from no known landmark.
#define SCPHD_HEALTH_CLUTTER_HIGH 8192

// Recently a fifth of the expected detections of known landmarks is missing.
#define SCPHD_HEALTH_DETECTIONS_LOW 16384

// The result of a call. A refused call leaves the filter unchanged, except for its time: see `scphd_slam_predict`.
enum scphd_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Success.
  SCPHD_STATUS_OK = 0,
  // A pointer is null, but must not be.
  SCPHD_STATUS_NULL_POINTER = 1,
  // A pointer is not aligned for its type.
  SCPHD_STATUS_MISALIGNED = 2,
  // The memory is smaller than the set requires.
  SCPHD_STATUS_MEMORY_TOO_SMALL = 3,
  // There is already a filter, detector or description in this memory. Release it first.
  SCPHD_STATUS_ALREADY_STARTED = 5,
  // There is nothing in this memory, or it was copied from another address.
  SCPHD_STATUS_NOT_STARTED = 6,
  // The memory contains another kind, or another set.
  SCPHD_STATUS_WRONG_MEMORY = 7,
  // Another call uses the same memory, from an interrupt or a second thread.
  SCPHD_STATUS_BUSY = 8,
  // The last call did not finish, so that its state cannot be resumed. Start again.
  SCPHD_STATUS_INTERRUPTED = 9,
  // `struct_size` is not the size in this library: it was not set, or the header is of another version.
  SCPHD_STATUS_WRONG_STRUCT_SIZE = 10,
  // The header and the library have different versions.
  SCPHD_STATUS_WRONG_VERSION = 11,
  // An array is longer than the address space.
  SCPHD_STATUS_ARRAY_TOO_LONG = 12,
  // A field is out of range; the reason names it.
  SCPHD_STATUS_OUT_OF_RANGE = 20,
  // The configuration has more particles or candidates than the set.
  SCPHD_STATUS_TOO_MANY_PARTICLES = 21,
  // The birth intensity of moving features is above 0, but the set has no memory for them.
  SCPHD_STATUS_NO_ROOM_FOR_MOVING = 22,
  // The memory was left by a filter with another configuration.
  SCPHD_STATUS_OTHER_CONFIGURATION = 23,
  // The contents of the memory are damaged.
  SCPHD_STATUS_DAMAGED = 24,
  // A pose is not finite, or a coordinate above 1e8.
  SCPHD_STATUS_BAD_POSE = 25,
  // The filter has not been reset to a pose yet.
  SCPHD_STATUS_NOT_RESET = 26,
  // The time step is negative or not finite.
  SCPHD_STATUS_BAD_TIME_STEP = 27,
  // A control is not finite, outside of the motion's domain, or of another vehicle.
  SCPHD_STATUS_BAD_CONTROL = 28,
  // The step is beyond the limits of the motion.
  SCPHD_STATUS_IMPLAUSIBLE = 29,
  // The scan has more measurements than its detector has memory for.
  SCPHD_STATUS_TOO_MANY_MEASUREMENTS = 30,
  // A measurement is not finite.
  SCPHD_STATUS_BAD_MEASUREMENT = 31,
  // The noise of a sensor or a fix is not positive definite.
  SCPHD_STATUS_BAD_NOISE = 32,
  // There is no setting with this number.
  SCPHD_STATUS_UNKNOWN_SETTING = 33,
  // The description has no such sensor, fix or part, or the sensor is of another type.
  SCPHD_STATUS_NOT_DESCRIBED = 34,
  // This filter does not support the call.
  SCPHD_STATUS_NOT_POSSIBLE = 35,
  // The memory has no capacity for a part of the description; the reason names it.
  SCPHD_STATUS_NO_ROOM = 36,
  // A map cannot be loaded: it is too long, or a feature is out of range.
  SCPHD_STATUS_BAD_MAP = 37,
  // The bytes are not a snapshot for this filter and memory, or damaged; or the memory for a snapshot is too small.
  SCPHD_STATUS_BAD_SNAPSHOT = 38,
  // The function is a service: call `scphd_services_...` of the filter's set first.
  SCPHD_STATUS_NO_SERVICES = 39,
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

// A description of a vehicle, its filter, sensors, fixes and start, in its memory. It may be used for several filters, and is
// not needed while they run.
typedef struct scphd_description scphd_description;

// A filter, in its memory.
typedef struct scphd_slam scphd_slam;

// A detector of range, bearing and elevation, in its memory.
typedef struct scphd_sonar_detector scphd_sonar_detector;

// A mixture under water, in its memory.
typedef struct scphd_water scphd_water;

// The reason why a description or a setting was refused. All zero if the call failed for another reason.
typedef struct scphd_reason {
  // `sizeof(scphd_reason)`, set by the caller.
  uint32_t struct_size;
  // Number of the setting, such as `SCPHD_JOINT_GATE`; `scphd_setting_name` and `scphd_setting_range` return its texts. 0 if
  // there is a `text`.
  uint32_t setting;
  // Index of the sensor, for a setting of a sensor.
  uint32_t sensor;
  // A line of UTF-8 that ends with a zero, such as "range_sigma_m must be finite and above 0", for settings that do not fit
  // together and for sonars. Empty if there is a `setting`.
  char text[116];
} scphd_reason;

// A static feature in the plane.
typedef struct scphd_feature {
  // Identifies the feature from scan to scan.
  uint32_t label;
  // Expected number of features that it represents; in a joint map its existence probability.
  float weight;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // Covariance: xx, xy, yy, m^2.
  float covariance[3];
} scphd_feature;

// The report of a prediction.
typedef struct scphd_predict_report {
  // `sizeof(scphd_predict_report)`, set by the caller.
  uint32_t struct_size;
  // Warnings: bits of `SCPHD_HEALTH_...`; 0 is good.
  uint32_t health;
  // Candidates after the prediction.
  uint32_t candidates;
  // Candidates that were not moved because their predicted pose was out of the range of single precision.
  uint32_t rejected;
  // Predictions that were refused since the last scan.
  uint32_t refused;
} scphd_predict_report;

// A measurement of range and bearing.
typedef struct scphd_range_bearing {
  // Range, m.
  float range_m;
  // Bearing, rad, 0 ahead, positive to the left.
  float bearing_rad;
} scphd_range_bearing;

// The report of a scan. Fields that do not apply are 0: for example, only mixtures have pages and candidates.
typedef struct scphd_scan_report {
  // `sizeof(scphd_scan_report)`, set by the caller.
  uint32_t struct_size;
  // Warnings: bits of `SCPHD_HEALTH_...`; 0 is good.
  uint32_t health;
  // Measurements in the scan.
  uint32_t measurements;
  // Measurements that could not become a feature or component.
  uint32_t no_birth;
  // Predictions that were refused since the last scan.
  uint32_t refused;
  // Features in view, or the greatest number of components in view of any candidate.
  uint32_t in_view;
  // New features or components.
  uint32_t births;
  // Features or components that were merged into another one.
  uint32_t merged;
  // Features or components that were discarded because of too little memory.
  uint32_t lost;
  // Features of a joint map that were removed because their existence probability was too low.
  uint32_t dropped;
  // Features of a joint map after the scan.
  uint32_t features;
  // Moving-object tracks of a joint map after the scan.
  uint32_t movers;
  // Hypotheses of data association of a joint map after the scan.
  uint32_t hypotheses;
  // Candidates that were weighted.
  uint32_t candidates;
  // Particles after the scan.
  uint32_t particles;
  // Whether the particles were resampled: 0 or 1.
  uint32_t resampled;
  // Pages of static features in use after the scan.
  uint32_t pages_used;
  // Total number of pages for static features.
  uint32_t pages;
  // Pages of moving features in use after the scan.
  uint32_t moving_pages_used;
  // Total number of pages for moving features.
  uint32_t moving_pages;
  // Effective number of candidates before resampling.
  float n_eff;
  // Logarithm of the scan's likelihood, up to a constant; minus infinity if no candidate explains the scan.
  float ln_evidence;
  // Expected number of detections of the features in view.
  float expected_detections;
  // Expected number of measurements that come from features in view.
  float detections;
  // Normalised innovation squared per dimension; about 1 for a consistent filter, 0 without detections.
  float innovation;
  // Probability of the likeliest hypothesis, of which the other fields are.
  float share;
} scphd_scan_report;

// The report of a fix.
typedef struct scphd_fix_report {
  // `sizeof(scphd_fix_report)`, set by the caller.
  uint32_t struct_size;
  // Whether the fix was used: 0 or 1. One beyond the gate is not.
  uint32_t accepted;
  // Whether the filter was moved because rejected fixes agree with each other: 0 or 1.
  uint32_t relocated;
  // Squared Mahalanobis distance of the innovation.
  float distance;
  // Logarithm of the likelihood of the fix; 0 if it was not used.
  float ln_evidence;
  // Effective number of candidates after the fix.
  float n_eff;
} scphd_fix_report;

// A pose in the plane and its covariance.
typedef struct scphd_plane_pose {
  // `sizeof(scphd_plane_pose)`, set by the caller.
  uint32_t struct_size;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // Heading from the x axis towards the y axis, rad.
  float heading_rad;
  // Covariance of (x, y, heading), row by row, in the squares of their units.
  float covariance[9];
} scphd_plane_pose;

// The estimated odometry error: the controls are multiplied by 1 + scale, and the offset is added to the turn rate or steering
// angle.
typedef struct scphd_odometry {
  // `sizeof(scphd_odometry)`, set by the caller.
  uint32_t struct_size;
  // Relative correction of the speed.
  float speed_scale;
  // Relative correction of the turn rate or steering angle.
  float turn_scale;
  // Offset of the turn rate, rad/s, or of the steering angle, rad.
  float turn_offset;
} scphd_odometry;

// Properties of an estimated map, without the features.
typedef struct scphd_map {
  // `sizeof(scphd_map)`, set by the caller.
  uint32_t struct_size;
  // Number of features that were written to the array.
  uint32_t features;
  // Number of features that did not fit into the array.
  uint32_t left_out;
  // The expected number of features.
  float expected_features;
} scphd_map;

// A moving feature in the plane.
typedef struct scphd_mover {
  // Identifies the feature from scan to scan.
  uint32_t label;
  // Expected number of features that it represents.
  float weight;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // Velocity along x, m/s.
  float vx_mps;
  // Velocity along y, m/s.
  float vy_mps;
  // Covariance of (x, y, vx, vy): its lower triangle, row by row.
  float covariance[10];
} scphd_mover;

// The pose of a sensor on its vehicle, relative to the vehicle's pose: x ahead, y to the left, z upwards. The rotation is roll,
// then pitch, then yaw.
typedef struct scphd_mounting {
  // Position ahead, m.
  float forward_m;
  // Position to the left, m.
  float left_m;
  // Position upwards, m.
  float up_m;
  // Rotation about the axis ahead, rad.
  float roll_rad;
  // Rotation about the axis to the left, rad.
  float pitch_rad;
  // Rotation about the axis upwards, rad.
  float yaw_rad;
} scphd_mounting;

// The parameters of a sonar.
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
  // Half width of the ramp at the greatest range, m.
  float range_edge_m;
  // Half width of the view in bearing, rad; pi or more: all around.
  float bearing_half_width_rad;
  // Half width of the view in elevation, rad; pi/2 or more: everything.
  float elevation_half_width_rad;
  // Half width of the ramps at the edges in bearing and elevation, rad.
  float angle_edge_rad;
  // Probability of detection, in [0, 1).
  float probability;
  // Expected number of false measurements in a scan.
  float clutter_per_scan;
  // Birth intensity of static features, 1/(m rad^2).
  float births_still;
  // Pose of the sensor on the vehicle.
  struct scphd_mounting mounting;
} scphd_sonar_config;

// The parameters of a vehicle under water.
typedef struct scphd_water_config {
  // `sizeof(scphd_water_config)`, set by the caller.
  uint32_t struct_size;
  // Standard deviation of the angular acceleration about the vertical, rad/s^2.
  float yaw_acceleration_sigma_radps2;
  // Correlation time of the velocity noise, s. 0: independent noise in every prediction.
  float velocity_interval_s;
} scphd_water_config;

// The control of a step.
typedef struct scphd_water_control {
  // `sizeof(scphd_water_control)`, set by the caller.
  uint32_t struct_size;
  // Velocity along the vehicle's axes, x ahead, y to the left, z upwards, m/s.
  float velocity_mps[3];
  // Covariance of the velocity: xx, xy, yy, xz, yz, zz, m^2/s^2.
  float velocity_covariance[6];
  // Roll at the end of the step, rad.
  float roll_rad;
  // Pitch at the end of the step, rad.
  float pitch_rad;
  // Mean yaw rate during the step, rad/s.
  float yaw_rate_radps;
  // Standard deviation of the yaw rate, rad/s. 0: no gyroscope.
  float yaw_rate_sigma_radps;
  // z at the end of the step, m, positive upwards: minus the depth.
  float z_m;
  // Standard deviation of z, m. 0: no pressure sensor.
  float z_sigma_m;
} scphd_water_control;

// A measurement of range, bearing and elevation.
typedef struct scphd_sonar {
  // Range, m.
  float range_m;
  // Bearing, rad, 0 ahead, positive to the left.
  float bearing_rad;
  // Elevation, rad, 0 horizontal, positive upwards.
  float elevation_rad;
} scphd_sonar;

// The model of a height or heading measurement under water.
typedef struct scphd_fix {
  // `sizeof(scphd_fix)`, set by the caller.
  uint32_t struct_size;
  // Standard deviation of the noise, m for a height, rad for a heading.
  float sigma;
  // Squared Mahalanobis distance beyond which the fix is an outlier; 0: no gate.
  float gate;
} scphd_fix;

// A pose under water and its covariance.
typedef struct scphd_water_pose {
  // `sizeof(scphd_water_pose)`, set by the caller.
  uint32_t struct_size;
  // x, m.
  float x_m;
  // y, m.
  float y_m;
  // z, m, positive upwards: minus the depth.
  float z_m;
  // Yaw from the x axis towards the y axis, rad.
  float yaw_rad;
  // Yaw rate, rad/s.
  float yaw_rate_radps;
  // Roll, from the last control, rad.
  float roll_rad;
  // Pitch, from the last control, rad.
  float pitch_rad;
  // Covariance of (x, y, z, yaw, yaw rate), row by row, in the squares of their units.
  float covariance[25];
} scphd_water_pose;

// A static feature in space.
typedef struct scphd_feature_3d {
  // Identifies the feature from scan to scan.
  uint32_t label;
  // Expected number of features that it represents.
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

// The interface version of the library; `SCPHD_ABI_VERSION` is that of the header.
uint32_t scphd_abi_version(void);

// The meaning of a status, a line of English; any number is allowed. The text is static.
const char *scphd_error_text(int32_t status);

// Required alignment of the memory of every set, bytes: `SCPHD_ALIGNMENT`.
size_t scphd_memory_alignment(void);

// Releases this memory, whatever it contains; it can then be started again. Earlier handles to it are refused from then on.
scphd_status scphd_release(void *memory,
                           size_t size_bytes);

// The name of the lowest warning in `health`, as in docs/health.md; call it with each bit separately. "GOOD" if there is none.
// The text is static.
const char *scphd_health_text(uint32_t health);

// Starts a description in this memory of `SCPHD_SIZE_DESCRIPTION` bytes: a robot that turns in place, with a joint map and
// without sensors. Writes the handle to `description`, or null.
scphd_status scphd_description_start(uint32_t abi_version,
                                     void *memory,
                                     size_t size_bytes,
                                     scphd_description **description);

// Sets one of the settings above, such as `SCPHD_VEHICLE_KIND`. For `SCPHD_SENSOR_...`, `sensor` is the index of the sensor, 0
// to 3. If the setting is a choice, `number` is the index of the choice. The reason may be null.
scphd_status scphd_description_set(scphd_description *description,
                                   uint32_t setting,
                                   size_t sensor,
                                   float number,
                                   scphd_reason *reason);

// Reads a setting. Returns `SCPHD_STATUS_NOT_DESCRIBED` if the description has no such part.
scphd_status scphd_description_get(scphd_description *description,
                                   uint32_t setting,
                                   size_t sensor,
                                   float *number);

// The name of a setting, such as "joint.gate". The text is static.
const char *scphd_setting_name(uint32_t setting);

// The range of a setting, such as "finite and at least 0". The text is static.
const char *scphd_setting_range(uint32_t setting);

// Replaces the description by one with the same parts, at any time between other calls; the settings of movers, archive and
// hypotheses of a joint map must not change. The monitoring of rejected fixes starts again. The reason may be null. A service.
scphd_status scphd_slam_configure(scphd_slam *slam,
                                  scphd_description *description,
                                  scphd_reason *reason);

// Starts the filter, or starts it again, with an empty map, and the pose and standard deviations of the description.
scphd_status scphd_slam_reset(scphd_slam *slam, scphd_description *description);

// Sets the pose and its standard deviations, and keeps the map. A service.
scphd_status scphd_slam_relocate(scphd_slam *slam,
                                 float x_m,
                                 float y_m,
                                 float heading_rad,
                                 float position_sigma_m,
                                 float heading_sigma_rad);

// Adds these standard deviations, in quadrature, to the uncertainty of the pose; the map is kept. A service.
scphd_status scphd_slam_scatter(scphd_slam *slam, float position_sigma_m, float heading_sigma_rad);

// Replaces the map by this one, of at most 128 features. An archive is emptied: the map must fit the window. A service.
scphd_status scphd_slam_load_map(scphd_slam *slam, const scphd_feature *features, size_t count);

// Predicts the pose after `dt_s` seconds. Speed ahead; speed to the left, 0 unless the vehicle can move sideways; turn rate to
// the left, rad/s, or steering angle of a car, rad. The report may be null. If the control is refused, the time of the filter
// advances nevertheless, and the next report counts the refusal.
scphd_status scphd_slam_predict(scphd_slam *slam,
                                float speed_mps,
                                float left_mps,
                                float turn,
                                float dt_s,
                                scphd_predict_report *report);

// Updates the filter with a scan of ranges and bearings of the sensor with this index in the description. The report may be
// null, and so may the measurements if `count` is 0.
scphd_status scphd_slam_scan_range_bearing(scphd_slam *slam,
                                           size_t sensor,
                                           const scphd_range_bearing *measurements,
                                           size_t count,
                                           scphd_scan_report *report);

// Updates the filter with a scan of bearings, rad, 0 ahead, positive to the left. As `scphd_slam_scan_range_bearing`.
scphd_status scphd_slam_scan_bearing(scphd_slam *slam,
                                     size_t sensor,
                                     const float *bearings_rad,
                                     size_t count,
                                     scphd_scan_report *report);

// Updates only the pose with a scan of ranges and bearings; the map does not change. For joint maps. A service.
scphd_status scphd_slam_localise(scphd_slam *slam,
                                 size_t sensor,
                                 const scphd_range_bearing *measurements,
                                 size_t count,
                                 scphd_scan_report *report);

// Updates the filter with a measured position, at any time between other calls. Its monitoring is a service. The report may be
// null.
scphd_status scphd_slam_observe_position(scphd_slam *slam,
                                         float x_m,
                                         float y_m,
                                         scphd_fix_report *report);

// Updates the filter with a measured heading, from the x axis towards the y axis. As `scphd_slam_observe_position`.
scphd_status scphd_slam_observe_heading(scphd_slam *slam, float heading_rad, scphd_fix_report *report);

// Writes the pose estimate.
scphd_status scphd_slam_estimate_pose(scphd_slam *slam, scphd_plane_pose *pose);

// Writes the estimated odometry error, of a filter that estimates it.
scphd_status scphd_slam_estimate_odometry(scphd_slam *slam, scphd_odometry *odometry);

// Writes static features to an array of `capacity` elements, and counts those that do not fit. If `capacity` is 0 the array may
// be null.
scphd_status scphd_slam_estimate_map(scphd_slam *slam,
                                     scphd_feature *features,
                                     size_t capacity,
                                     scphd_map *map);

// Writes moving features to an array of `capacity` elements, and counts those that do not fit. If `capacity` is 0 the array may
// be null.
scphd_status scphd_slam_estimate_movers(scphd_slam *slam,
                                        scphd_mover *movers,
                                        size_t capacity,
                                        scphd_map *map);

// Writes a snapshot to `room`, from which a filter with the same description and set continues bit for bit, except for the
// monitoring of fixes. `kind` is a number of the vehicle type. `written` is set to the size of the snapshot, bytes. If the
// capacity is 0, `room` may be null and nothing is written to it. A service.
scphd_status scphd_slam_save(scphd_slam *slam,
                             uint32_t kind,
                             uint8_t *room,
                             size_t capacity,
                             size_t *written);

// Restores a snapshot. If its contents are refused, the filter has to be reset. A service.
scphd_status scphd_slam_restore(scphd_slam *slam, uint32_t kind, const uint8_t *snapshot, size_t size_bytes);

// Writes a hash of the whole state: the same inputs give the same hash on every machine. A service.
scphd_status scphd_slam_digest(scphd_slam *slam, uint64_t *digest);

// Checks the whole state. Returns `SCPHD_STATUS_DAMAGED` if memory was damaged. A service.
scphd_status scphd_slam_audit(scphd_slam *slam);

// Writes the defaults of a sonar with this greatest range, m, and this probability of detection, in [0, 1): a view of all
// directions, one false measurement in a scan, one new feature in ten scans, at the vehicle's pose. The standard deviations of
// the noise are 0, which is out of range: set them.
scphd_status scphd_sonar_defaults(scphd_sonar_config *config,
                                  float range_max_m,
                                  float probability);

// Starts a detector in this memory of `SCPHD_SIZE_SONAR_64` bytes. `abi_version` is `SCPHD_ABI_VERSION`. The reason may be null.
// Writes the handle to `detector`, or null.
scphd_status scphd_sonar_start(uint32_t abi_version,
                               void *memory,
                               size_t size_bytes,
                               const scphd_sonar_config *config,
                               scphd_reason *reason,
                               scphd_sonar_detector **detector);

// Starts a filter in this memory of `SCPHD_SIZE_WATER_INFORMED_16` bytes, which is zero or was released. `abi_version` is
// `SCPHD_ABI_VERSION`. Only the mixture's settings and the limits of the motion are used from the description. The reason may be
// null. Writes the handle to `filter`, or null. Reset it to a pose next.
scphd_status scphd_water_start(uint32_t abi_version,
                               void *memory,
                               size_t size_bytes,
                               scphd_description *description,
                               const scphd_water_config *config,
                               scphd_reason *reason,
                               scphd_water **filter);

// Resumes the filter that the same build of this library has left in this memory: after a reset of the processor that kept it,
// or in a copy of it.
scphd_status scphd_water_resume(uint32_t abi_version,
                                void *memory,
                                size_t size_bytes,
                                scphd_description *description,
                                const scphd_water_config *config,
                                scphd_reason *reason,
                                scphd_water **filter);

// Sets position and yaw of a vehicle that is level and at rest, clears the map and seeds the random numbers.
scphd_status scphd_water_reset(scphd_water *filter,
                               float x_m,
                               float y_m,
                               float z_m,
                               float yaw_rad,
                               uint64_t seed);

// Predicts the pose after `dt_s` seconds. The report may be null. If the control is refused, see `scphd_slam_predict`.
scphd_status scphd_water_predict(scphd_water *filter,
                                 const scphd_water_control *control,
                                 float dt_s,
                                 scphd_predict_report *report);

// Updates the filter with a scan of ranges, bearings and elevations. The report may be null, and so may the measurements if
// `count` is 0.
scphd_status scphd_water_scan_sonar(scphd_water *filter,
                                    scphd_sonar_detector *detector,
                                    const scphd_sonar *measurements,
                                    size_t count,
                                    scphd_scan_report *report);

// Updates the filter with a measured z, m, positive upwards: minus the depth. The report may be null.
scphd_status scphd_water_observe_height(scphd_water *filter,
                                        const scphd_fix *fix,
                                        float z_m,
                                        scphd_fix_report *report);

// Updates the filter with a measured yaw, from the x axis towards the y axis. The report may be null.
scphd_status scphd_water_observe_heading(scphd_water *filter,
                                         const scphd_fix *fix,
                                         float yaw_rad,
                                         scphd_fix_report *report);

// Writes the pose estimate.
scphd_status scphd_water_estimate_pose(scphd_water *filter, scphd_water_pose *pose);

// Writes features to an array of `capacity` elements, and counts those that do not fit. If `capacity` is 0 the array may be
// null.
scphd_status scphd_water_estimate_map(scphd_water *filter,
                                      scphd_feature_3d *features,
                                      size_t capacity,
                                      scphd_map *map);

// As `scphd_slam_digest`.
scphd_status scphd_water_digest(scphd_water *filter, uint64_t *digest);

// Start the filter that is described in this memory, which is zero or was released: `abi_version` is `SCPHD_ABI_VERSION`,
// `size_bytes` at least the SCPHD_SIZE_... of the set. The reason may be null. The handle is written to `slam`, or null. Reset
// the filter next.
//
// Those that resume go on with what the same build of this library has left in this memory: after a reset of the processor
// that kept it, or in a copy of it. The description may be another, but for particles, samples and proposal of a mixture. What
// is found of a mixture is checked, of a joint map taken as it is; it is no checksum, and memory that may have been damaged needs
// one.
//
// Services are the functions that say so above. scphd_services_... of its set provides them for a filter, until this is started or
// resumed again. A program that does not call it does not contain them.

// Joint map: 40 features, scans of 32 measurements.
scphd_status scphd_start_joint_40(uint32_t abi_version, void *memory, size_t size_bytes,
                                  scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_joint_40(uint32_t abi_version, void *memory, size_t size_bytes,
                                   scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_joint_40(scphd_slam *slam);

// Joint map: 100 features, scans of 32 measurements.
scphd_status scphd_start_joint_100(uint32_t abi_version, void *memory, size_t size_bytes,
                                   scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_joint_100(uint32_t abi_version, void *memory, size_t size_bytes,
                                    scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_joint_100(scphd_slam *slam);

// Joint map: 60 static and 16 moving features, scans of 32 measurements.
scphd_status scphd_start_joint_60_movers(uint32_t abi_version, void *memory, size_t size_bytes,
                                         scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_joint_60_movers(uint32_t abi_version, void *memory, size_t size_bytes,
                                          scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_joint_60_movers(scphd_slam *slam);

// Joint map: 100 static and 32 moving features, scans of 32 measurements.
scphd_status scphd_start_joint_100_movers(uint32_t abi_version, void *memory, size_t size_bytes,
                                          scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_joint_100_movers(uint32_t abi_version, void *memory, size_t size_bytes,
                                           scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_joint_100_movers(scphd_slam *slam);

// Joint map: 40 static and 16 moving features, and an archive of 1000 distant features; scans of 32 measurements.
scphd_status scphd_start_joint_40_archive(uint32_t abi_version, void *memory, size_t size_bytes,
                                          scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_joint_40_archive(uint32_t abi_version, void *memory, size_t size_bytes,
                                           scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_joint_40_archive(scphd_slam *slam);

// Joint map that estimates the odometry error: 60 features, scans of 32 measurements.
scphd_status scphd_start_joint_60_learning(uint32_t abi_version, void *memory, size_t size_bytes,
                                           scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_joint_60_learning(uint32_t abi_version, void *memory, size_t size_bytes,
                                            scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_joint_60_learning(scphd_slam *slam);

// Joint map with eight hypotheses of data association, each with 24 static and 8 moving features; scans of 16 measurements.
scphd_status scphd_start_joint_24_hypotheses(uint32_t abi_version, void *memory, size_t size_bytes,
                                             scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_joint_24_hypotheses(uint32_t abi_version, void *memory, size_t size_bytes,
                                              scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_joint_24_hypotheses(scphd_slam *slam);

// Mixture: 32 particles of two samples, 320 pages of features, 32 to a map, 256 in view; 128 pages of moving ones; scans of 128 measurements, of range and bearing or of bearings alone.
scphd_status scphd_start_mixture_32x2(uint32_t abi_version, void *memory, size_t size_bytes,
                                      scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_mixture_32x2(uint32_t abi_version, void *memory, size_t size_bytes,
                                       scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_mixture_32x2(scphd_slam *slam);

// Mixture: four informed particles, 128 pages of features, 32 to a map, 256 in view; no moving ones; scans of 64 measurements.
scphd_status scphd_start_mixture_informed_4(uint32_t abi_version, void *memory, size_t size_bytes,
                                            scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_mixture_informed_4(uint32_t abi_version, void *memory, size_t size_bytes,
                                             scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_mixture_informed_4(scphd_slam *slam);

// As the previous one, with 64 pages of moving features, 16 to a map, 128 in view.
scphd_status scphd_start_mixture_informed_4_moving(uint32_t abi_version, void *memory, size_t size_bytes,
                                                   scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_resume_mixture_informed_4_moving(uint32_t abi_version, void *memory, size_t size_bytes,
                                                    scphd_description *description, scphd_reason *reason, scphd_slam **slam);
scphd_status scphd_services_mixture_informed_4_moving(scphd_slam *slam);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SCPHD_H */
