// Memory that changes take when they are prepared, told before they are.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <cstdint>

#include "cwm/v1/world.pb.h"
#include "server/core/geometry_store.h"

namespace cwm::server {

// Bytes, to the nearest factor of two, of the objects that are put. Meshes of which the store knows
// nothing count nothing: they are refused.
std::int64_t PreparedBytes(const google::protobuf::RepeatedPtrField<v1::Change>& changes,
                           const GeometryStore& store);

}  // namespace cwm::server
