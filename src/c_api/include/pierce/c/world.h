/** Worlds: how they are made, destroyed and saved. */
#ifndef PIERCE_C_WORLD_H
#define PIERCE_C_WORLD_H

#include "pierce/c/settings.h"

PIERCE_C_BEGIN

/** Makes a world. `settings`, `backend`: null for the defaults. The caller destroys it. Errors:
 *  impossible settings, a backend that is not built in or cannot run. */
PIERCE_API pierce_status pierce_create_world(const pierce_settings* settings,
                                             const pierce_backend_options* backend,
                                             pierce_world** world);
/** Destroys a world and all that its calls have given out, but for kept contacts. Null: nothing
 *  happens. */
PIERCE_API void pierce_destroy_world(pierce_world* world);

/** The backend's name and how it was made, for people. Valid until the world is destroyed or this
 *  is called again. */
PIERCE_API pierce_status pierce_backend(pierce_world* world, const char** description);

/** Takes `size` bytes and returns 0, or anything else to stop. It must not throw or jump. */
typedef int (*pierce_write)(const void* bytes, size_t size, void* user);

/** Writes the world: settings, meshes, bodies, and what the last step keeps for the next one, but
 *  no contacts; places in device memory as they are now. `user` is handed to `write`, which is
 *  called several times. Errors: `write` stops. */
PIERCE_API pierce_status pierce_save(const pierce_world* world, pierce_write write, void* user);
/** Makes a world from `size` bytes that pierce_save() has written, on any backend (null: the
 *  default). Numbers of meshes and bodies stay valid. Errors: any other content. */
PIERCE_API pierce_status pierce_restore(const void* bytes, size_t size,
                                        const pierce_backend_options* backend,
                                        pierce_world** world);

PIERCE_C_END

#endif
