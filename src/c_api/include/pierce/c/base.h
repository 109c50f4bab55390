/** What all calls share: status, messages, handles, the version. */
#ifndef PIERCE_C_BASE_H
#define PIERCE_C_BASE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define PIERCE_C_BEGIN extern "C" {
#define PIERCE_C_END }
#else
#define PIERCE_C_BEGIN
#define PIERCE_C_END
#endif
#define PIERCE_API __attribute__((visibility("default")))

#define PIERCE_VERSION_MAJOR 0
#define PIERCE_VERSION_MINOR 1
#define PIERCE_VERSION_PATCH 0

PIERCE_C_BEGIN

/** What a call returns. New values may follow. */
typedef enum pierce_status {
    PIERCE_OK = 0,
    PIERCE_INVALID_INPUT = 1, /**< an argument cannot be used; the message names it */
    PIERCE_NOT_BUILT = 2,     /**< this library was built without the backend */
    PIERCE_OUT_OF_MEMORY = 3,
    PIERCE_INTERNAL = 4 /**< anything else, such as an error of the CUDA driver */
} pierce_status;

/** Names a mesh of a world; 0 names none. A removed mesh's number never becomes valid again. */
typedef uint64_t pierce_mesh_id;
/** Names a body of a world; 0 names none. A removed body's number never becomes valid again. Its
 *  lower 32 bits are the place by which contacts are sorted. */
typedef uint64_t pierce_body_id;

/** Bodies and their contacts. One thread at a time may use it; different worlds are independent. */
typedef struct pierce_world pierce_world;

/** Stands for a vertex or triangle where there is none. */
#define PIERCE_NO_VERTEX UINT32_C(0xffffffff)
#define PIERCE_NO_TRIANGLE UINT32_C(0xffffffff)

/** Why this thread's last failed call failed, in a sentence for people; "" if none has. Valid until
 *  this thread's next failed call. Messages beyond 1023 bytes are cut. */
PIERCE_API const char* pierce_last_error(void);

/** The library's version, "0.1.0"; the macros above are the header's. */
PIERCE_API const char* pierce_version(void);

PIERCE_C_END

#endif
