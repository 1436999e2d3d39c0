// The library for C and for every language that can call C. Plain C99; engine/EMBEDDING.md is the whole contract.
//
// Units and frames: metres, radians and milliseconds; everything is in the frame of the cloud.
//
// Layout. Numbers of codes and statuses never change their meaning. Structs only grow, at their end, and each is passed
// with its size as the caller's compiler knows it (`sizeof`), so that programs and libraries of different age work
// together:
//   - a struct that the library reads: what an older caller does not know counts as zero; what a newer caller knows and
//     this library does not must be zero, otherwise HANDHOLD_BAD_SIZE;
//   - a struct that the library writes: as much as fits; what this library does not know is set to zero.
// Zero in every field of handhold_cloud that may be added means what the library did before. HANDHOLD_ABI is raised
// only when something that exists here changes or goes.
//
// Errors. Functions that can fail return a handhold_code; a message of one line stands beside the object until the
// next call that may change the object. There is no global and no per-thread state. No exception leaves a function.
//
// Threads. One object serves one call at a time, handhold_cancel apart; different objects may be used at once.
// Functions that take a pointer to const only read, so several threads may call them on one object as long as nothing
// else is called on it.
#ifndef HANDHOLD_HANDHOLD_H
#define HANDHOLD_HANDHOLD_H

#include <stddef.h>
#include <stdint.h>

#include "handhold/version.h"

/// Number of this interface's layout; compare with handhold_abi() where header and library may be of different age.
#define HANDHOLD_ABI 1

#if defined(__GNUC__)
#define HANDHOLD_API __attribute__((visibility("default")))
#else
#define HANDHOLD_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

// ---- Codes ---------------------------------------------------------------------------------------------------------

/// What a function returns: 0 for success, otherwise why it failed.
typedef int32_t handhold_code;
enum {
  HANDHOLD_OK = 0,
  HANDHOLD_NULL_ARGUMENT = 1,  ///< a pointer that is needed is NULL
  HANDHOLD_BAD_OBJECT = 2,     ///< a pointer to something else than the object that the function takes
  HANDHOLD_BAD_SIZE = 3,       ///< the size of a struct is none of its versions', or it has fields set that are unknown
  HANDHOLD_BAD_INDEX = 4,      ///< beyond the last handle or affordance
  HANDHOLD_BAD_OPTION = 5,     ///< unknown name, text that is no value, value out of range; the message says which
  HANDHOLD_BAD_CLOUD = 6,      ///< the cloud contradicts itself (no data, bad point_step, ...); the message says how
  HANDHOLD_NO_FRAME = 7,       ///< there is no result: no call of handhold_localize yet, or the last one failed
  HANDHOLD_BUSY = 8,           ///< another thread makes or reads this localizer's result; nothing was done
  HANDHOLD_NO_MEMORY = 9,      ///< out of memory; of a localizer only handhold_localizer_destroy is left
  HANDHOLD_FAILED = 10         ///< anything else; the message says what
};
/// The code in words; never NULL. "unknown code" for a number that is none.
HANDHOLD_API const char* handhold_code_text(handhold_code code);

/// How a frame went. Everything but HANDHOLD_STATUS_OK and HANDHOLD_STATUS_DEADLINE means that there are no handles and
/// says why. Later versions may have more: take an unknown one as "not searched".
typedef int32_t handhold_status;
enum {
  HANDHOLD_STATUS_OK = 0,                ///< the cloud was searched; there may still be no handles
  HANDHOLD_STATUS_EMPTY = 1,             ///< the cloud has no points
  HANDHOLD_STATUS_NO_FINITE_POINTS = 2,  ///< every point has a coordinate that is NaN, infinite or beyond 1e6 m
  HANDHOLD_STATUS_TOO_FEW_POINTS = 3,    ///< fewer finite points than one fit needs, or none in the workspace
  HANDHOLD_STATUS_SUSPICIOUS_UNITS = 4,  ///< the cloud is over 100 m wide: probably millimetres
  HANDHOLD_STATUS_DEADLINE = 5,          ///< option deadline_ms ended the search; what had been found by then is there
  HANDHOLD_STATUS_CANCELLED = 6          ///< handhold_cancel ended the search
};
/// "ok", "empty", "no_finite_points", "too_few_points", "suspicious_units", "deadline", "cancelled"; "unknown" for a
/// number that is none.
HANDHOLD_API const char* handhold_status_text(handhold_status status);

// ---- The library ---------------------------------------------------------------------------------------------------

/// Version of the library that runs, "0.1.0"; HANDHOLD_VERSION_STRING is that of the header.
HANDHOLD_API const char* handhold_version(void);
/// HANDHOLD_ABI of the library that runs. A program must not go on where it differs from its header's.
HANDHOLD_API uint32_t handhold_abi(void);
/// Instruction set of the kernels in use: "scalar", "avx2", "avx512" or "neon".
HANDHOLD_API const char* handhold_isa(void);

// ---- Options -------------------------------------------------------------------------------------------------------

/// Options by name and as text: the names, units and texts of the command line ("hand_aperture" for --hand-aperture)
/// and of TOML files.
typedef struct handhold_options handhold_options;

/// New options with the defaults. *options is NULL on failure.
HANDHOLD_API handhold_code handhold_options_create(handhold_options** options);
/// NULL is fine.
HANDHOLD_API void handhold_options_destroy(handhold_options* options);
/// All options anew: NULL: the defaults; "baxter": Baxter's electric gripper, the rest at its defaults.
HANDHOLD_API handhold_code handhold_options_reset(handhold_options* options, const char* hand);
/// Sets one option, as in handhold_set(options, "hand_aperture", "0.08"). Several numbers have blanks or commas between
/// them; "default" unsets an option that may be unset. The decimal point is a point in every locale. Ranges are judged
/// by handhold_localizer_create: only all options together can be.
HANDHOLD_API handhold_code handhold_set(handhold_options* options, const char* name, const char* text);
/// Reads one back, as text that handhold_set takes, bit for bit. *text stays valid until the next call on `options`; it
/// is NULL on failure.
HANDHOLD_API handhold_code handhold_get(handhold_options* options, const char* name, const char** text);
/// Why the last call on these options failed: one line that names option, value and what would be right; "" after a
/// success. Never NULL; valid until the next call on `options`.
HANDHOLD_API const char* handhold_options_message(const handhold_options* options);

/// Number of options, and of each its name, its unit ("m", "rad", "mm^2"; "" for a count or a name) and one line of
/// help; NULL from handhold_option_count() on. Later versions may have more.
HANDHOLD_API size_t handhold_option_count(void);
HANDHOLD_API const char* handhold_option_name(size_t index);
HANDHOLD_API const char* handhold_option_unit(size_t index);
HANDHOLD_API const char* handhold_option_help(size_t index);

// ---- Localizer -----------------------------------------------------------------------------------------------------

/// Finds the graspable parts of clouds. Holds a copy of the options, memory that is reused from frame to frame, and the
/// last frame's result.
typedef struct handhold_localizer handhold_localizer;

/// A cloud in the caller's memory, which is never written and must live as long as the call. All zero but data, width
/// and height is a packed cloud whose sensor stood in the origin.
typedef struct handhold_cloud {
  const float* data;      ///< x of the first point: x, y, z (m) as three floats; NaN where nothing was measured
  uint32_t width;         ///< points in a row
  uint32_t height;        ///< rows of a depth camera's image, row-major; 1: unorganized
  uint32_t point_step;    ///< bytes from one point to the next: a multiple of 4, at least 12; 0: 12
  uint32_t no_viewpoint;  ///< 1: no single viewpoint (merged views); 0: the sensor stood at `viewpoint`
  double viewpoint[3];    ///< m
} handhold_cloud;

/// A localizer with a copy of the options, which may be changed or destroyed afterwards; NULL: the defaults. On failure
/// *localizer is NULL, and handhold_options_message(options) says which option is out of range, or why there is no GPU
/// for the option backend = "cuda".
HANDHOLD_API handhold_code handhold_localizer_create(handhold_options* options, handhold_localizer** localizer);
/// NULL is fine. Must not be called while handhold_localize runs.
HANDHOLD_API void handhold_localizer_destroy(handhold_localizer* localizer);
/// What frames run on: "cpu" or "cuda". Option backend = "auto" becomes one of them when the localizer is made.
HANDHOLD_API const char* handhold_localizer_backend(const handhold_localizer* localizer);
/// With backend = "auto", why frames run on the CPU, in one line; otherwise "". Valid until the localizer is destroyed.
/// Where `localizer` is none, both give what handhold_code_text says to that. Never NULL.
HANDHOLD_API const char* handhold_localizer_backend_reason(const handhold_localizer* localizer);
/// Searches a cloud, as in handhold_localize(localizer, &cloud, sizeof cloud). A cloud in which nothing can be found is
/// no error: handhold_frame.status says why. After a failure there is no result (HANDHOLD_NO_FRAME).
HANDHOLD_API handhold_code handhold_localize(handhold_localizer* localizer, const handhold_cloud* cloud, size_t size);
/// Ends the frame in progress, from another thread: its handhold_localize returns soon, with HANDHOLD_OK, the status
/// HANDHOLD_STATUS_CANCELLED and nothing found. Does nothing when none is in progress.
HANDHOLD_API handhold_code handhold_cancel(handhold_localizer* localizer);
/// Why the last handhold_localize failed, in one line; "" after a success. Never NULL; valid until the next one. The
/// functions below leave it alone: handhold_code_text says all about their failures.
HANDHOLD_API const char* handhold_localizer_message(const handhold_localizer* localizer);

// ---- Results of the last frame -------------------------------------------------------------------------------------

typedef struct handhold_frame {
  handhold_status status;
  uint32_t handles;        ///< number of them; best confidence first
  uint32_t affordances;    ///< number of them
  uint32_t reserved;       ///< 0
  uint64_t points;         ///< of the cloud
  uint64_t finite_points;  ///< of these, with coordinates that are all finite
} handhold_frame;

/// One graspable part. The pointers stay valid until the next handhold_localize or handhold_localizer_destroy.
typedef struct handhold_handle {
  double center[3];             ///< m; middle of the extent on the axis, or where `path` is best held
  double axis[3];               ///< unit; largest component positive
  double approach[3];           ///< unit; direction in which a hand moves towards the part
  double radius;                ///< m
  double length;                ///< m; extent along the axis
  double confidence;            ///< 0..1; probability that the handle is right (method "paper": not calibrated)
  double arc;                   ///< rad; angle about the axis within which points were measured; 0: method "paper"
  double residual;              ///< m; root mean square distance of the points from the cylinder; 0: method "paper"
  double observed_free;         ///< 0..1; share of the fingers' volumes that was seen empty; 0: method "paper"
  double normal_error;          ///< rad; mean angle between the points' normals and the cylinder's; 0: method "paper"
  const double* path;           ///< m; 3 * path_points: x, y, z along a curved handle's middle; NULL: straight
  const uint32_t* affordances;  ///< affordance_count indices for handhold_get_affordances, ascending
  uint32_t path_points;         ///< 0: straight
  uint32_t affordance_count;
} handhold_handle;

/// One cylindrical shell that may be grasped; handles are made of aligned ones.
typedef struct handhold_affordance {
  double center[3];      ///< m; point of the axis at the sample's height
  double axis[3];        ///< unit; direction of least curvature; largest component positive
  double normal[3];      ///< unit; outward, towards the sensor's side
  double radius;         ///< m; of the fitted circle
  double shell_radius;   ///< m; inner radius of the shell found
  double gap;            ///< m; free width found outside shell_radius
  double curvature;      ///< 1/m; median of the largest absolute curvature over the neighbourhood
  double observed_free;  ///< 0..1; share of the fingers' volumes that was seen empty; 0 where it was not looked at
  double quality;        ///< 0..1; how well the points fit the cylinder (method "default")
  double neighbourhood;  ///< m; radius of the ball; 0: found by its outline in the depth image
  uint32_t sample;       ///< number of the sample it came from
  uint32_t reserved;     ///< 0
} handhold_affordance;

/// How many samples ended at each step; the counts from too_few_points to cut add up to `samples`.
typedef struct handhold_funnel {
  int64_t samples;         ///< neighbourhoods looked at
  int64_t too_few_points;  ///< fewer neighbours than min_neighbours
  int64_t flat;            ///< points exactly on a plane, a line or in one place
  int64_t curvature_low;   ///< radius of curvature beyond reach, or flat within the noise
  int64_t concave;         ///< bends towards the sensor: a hollow (method "default")
  int64_t circle_wide;     ///< fitted circle wider than hand_aperture
  int64_t circle_narrow;   ///< fitted circle narrower than hand_minimum
  int64_t poor_fit;        ///< points too far from the cylinder, or on too little of it (method "default")
  int64_t no_gap;          ///< no empty gap for the fingers, or none that was seen
  int64_t shell_empty;     ///< a gap, but too few points within the shell
  int64_t affordances;     ///< samples that gave an affordance; the counts from not_aligned on add up to these
  int64_t cut;             ///< drawn, but not looked at to the end: deadline_ms came first
  int64_t not_aligned;     ///< in no group of handle_min_affordances aligned ones
  int64_t unconfirmed;     ///< in a group that the points do not bear out (method "default")
  int64_t too_short;       ///< in a group shorter than handle_min_length
  int64_t low_confidence;  ///< in a handle below min_confidence
  int64_t in_handles;      ///< in a reported handle, or askew on its part
} handhold_funnel;

/// Wall-clock time of each step (ms). Steps that run side by side share the time of their common section: all add up to
/// `total`.
typedef struct handhold_times {
  double index;       ///< tiles and BVH or grid
  double samples;     ///< drawing, snapping, sorting and grouping of samples
  double neighbours;  ///< index queries
  double moments;     ///< culling of boxes, rough planes, sums
  double fit;         ///< quadric, curvature, circle
  double shell;       ///< shells, or cylinders and fingers
  double visibility;  ///< depth image of what was seen
  double handles;
  double total;
} handhold_times;

/// Copies of the last frame's results into the caller's structs, as in handhold_get_frame(localizer, &frame, sizeof
/// frame). HANDHOLD_NO_FRAME when there is none.
HANDHOLD_API handhold_code handhold_get_frame(const handhold_localizer* localizer, handhold_frame* frame, size_t size);
HANDHOLD_API handhold_code handhold_get_funnel(const handhold_localizer* localizer, handhold_funnel* funnel,
                                               size_t size);
HANDHOLD_API handhold_code handhold_get_times(const handhold_localizer* localizer, handhold_times* times, size_t size);
/// Copies `count` handles from the first-th on into an array; `size` is that of one element. Writes all or nothing:
/// HANDHOLD_BAD_INDEX when there are not so many. With a count of 0 the array may be NULL.
HANDHOLD_API handhold_code handhold_get_handles(const handhold_localizer* localizer, size_t first, size_t count,
                                                handhold_handle* handles, size_t size);
/// The same for affordances.
HANDHOLD_API handhold_code handhold_get_affordances(const handhold_localizer* localizer, size_t first, size_t count,
                                                    handhold_affordance* affordances, size_t size);

#ifdef __cplusplus
}
#endif

#endif
