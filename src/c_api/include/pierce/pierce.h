/** The C API of Pierce: contacts between triangle meshes by ray tracing. C99 and C++.
 *
 *  docs/c_api.md says how to use it. In short: every call but the destroying ones returns a
 *  pierce_status, and pierce_last_error() has the message; a call that fails changes nothing, and
 *  leaves what its out parameters point to as it was. Lengths are in the caller's unit, angles in
 *  radians. */
#ifndef PIERCE_PIERCE_H
#define PIERCE_PIERCE_H

#include "pierce/c/base.h"
#include "pierce/c/body.h"
#include "pierce/c/contact.h"
#include "pierce/c/device.h"
#include "pierce/c/mesh.h"
#include "pierce/c/mesh_check.h"
#include "pierce/c/places.h"
#include "pierce/c/queries.h"
#include "pierce/c/settings.h"
#include "pierce/c/step.h"
#include "pierce/c/world.h"
#include "pierce/c/worlds.h"

#endif
