// The C++ client. Its headers need the standard library and Eigen alone.
#pragma once

#include "cwm/changes.h"
#include "cwm/error.h"
#include "cwm/live.h"
#include "cwm/objects.h"
#include "cwm/queries.h"
#include "cwm/results.h"
#include "cwm/robots.h"
#include "cwm/scans.h"
#include "cwm/shapes.h"
#include "cwm/watch.h"
#include "cwm/world.h"
