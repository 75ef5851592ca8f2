// Estimates the memory that prepared changes will take, before they are prepared.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <cstdint>

#include "cwm/v1/world.pb.h"
#include "server/core/geometry_store.h"

namespace cwm::server {

// Bytes, within a factor of two, of the objects that the changes put. Meshes that the store does
// not have count as nothing, since they are refused later.
std::int64_t PreparedBytes(const google::protobuf::RepeatedPtrField<v1::Change>& changes,
                           const GeometryStore& store);

}  // namespace cwm::server
