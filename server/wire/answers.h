// Answer columns onto the wire: as bytes, column by column, or as messages row by row. Objects
// and robots are named by an index into the reply's own list, ordered by name, of those that
// answers mention.
#pragma once

#include <string>
#include <vector>

#include "collision/motion/check_motions.h"
#include "collision/query/query.h"
#include "cwm/v1/query.pb.h"
#include "server/wire/questions.h"

namespace cwm::server {

struct AnswerContext {
  std::string world_uid;
  collision::Revision revision;              // of the world
  const collision::WorldSnapshot& snapshot;  // with the request's overlay, if it has one
  Form form = Form::kColumns;
  Precision precision = Precision::kDouble;
  bool verdicts_only = false;  // of collisions: no pair is named
  BodyNames body = {};         // of a robot that asks
};

void ToProto(const collision::CollisionColumns& answers, const AnswerContext& context,
             v1::CheckCollisionsResponse* response);
void ToProto(const collision::PairColumns& answers, const AnswerContext& context,
             v1::GetDistancesResponse* response);
void ToProto(const collision::PairColumns& answers, const AnswerContext& context,
             v1::GetContactsResponse* response);
// Single precision rounds `lo` and the clearance down and `hi` up: they stay bounds.
void ToProto(const collision::MotionColumns& answers, const AnswerContext& context,
             v1::CheckMotionsResponse* response);
// `rays` are the rows that were asked, for the points of rows.
void ToProto(const collision::RayColumns& answers, std::span<const collision::RayRow> rays,
             const AnswerContext& context, v1::CastRaysResponse* response);

void ToProto(const collision::PointColumns& answers, const AnswerContext& context,
             v1::SamplePointsResponse* response);

}  // namespace cwm::server
