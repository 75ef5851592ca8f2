// What the C++ client is made of: stubs, messages and helpers for them, with the headers of gRPC
// and Protobuf. Installed as <cwm/rpc.h>.
#pragma once

#include "clients/cpp/call_error.h"
#include "clients/cpp/cloud_upload.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/cpp/point_labels.h"
#include "clients/cpp/progress.h"
#include "clients/cpp/query_stream.h"
#include "clients/cpp/robot_upload.h"
#include "clients/cpp/row_bytes.h"
#include "clients/cpp/sensor_stream.h"
#include "clients/cpp/world_export.h"
#include "clients/cpp/world_stream.h"
