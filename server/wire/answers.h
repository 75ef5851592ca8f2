// Writes answer columns to messages: as bytes, column by column, or as messages row by row. Objects
// and robots are named by an index into the reply's own list of those that answers mention, ordered
// by name.
#pragma once

#include <string>
#include <vector>

#include "collision/motion/check_motions.h"
#include "collision/query/get_world_contacts.h"
#include "collision/query/query.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/robot.pb.h"
#include "server/wire/queries.h"

namespace cwm::server {

struct AnswerContext {
  std::string world_uid;
  collision::Revision revision;              // the world's
  const collision::WorldSnapshot& snapshot;  // with the request's overlay, if any
  Form form = Form::kColumns;
  Precision precision = Precision::kDouble;
  bool verdicts_only = false;    // of collisions: no pair is named
  bool joint_gradients = false;  // of distances: the variables of a row are named
  BodyNames body = {};           // if the subject is a robot
};

void CollisionAnswersToProto(const collision::CollisionColumns& answers,
                             const AnswerContext& context, v1::CheckCollisionsResponse* response);
void DistanceAnswersToProto(const collision::PairColumns& answers, const AnswerContext& context,
                            v1::GetDistancesResponse* response);
void ContactAnswersToProto(const collision::PairColumns& answers, const AnswerContext& context,
                           v1::GetContactsResponse* response);
void WorldContactAnswersToProto(const collision::WorldContactColumns& answers,
                                const AnswerContext& context,
                                v1::GetWorldContactsResponse* response);
// Single precision rounds `lo` and the clearance down and `hi` up, so that they stay bounds.
void MotionAnswersToProto(const collision::MotionColumns& answers, const AnswerContext& context,
                          v1::CheckMotionsResponse* response);
// `rays` are the rows of the query, needed for the points of rows.
void RayAnswersToProto(const collision::RayColumns& answers,
                       std::span<const collision::RayRow> rays, const AnswerContext& context,
                       v1::CastRaysResponse* response);

void PoseAnswersToProto(const collision::PoseColumns& answers, const PoseQuery& query,
                        const AnswerContext& context, v1::SolvePosesResponse* response);

// The poses of links in the rows of a robot, as many rows as there is budget for.
void LinkPosesToProto(const StateQuery& query, std::span<const int> links,
                      const AnswerContext& context, WorkBudget* budget,
                      v1::GetLinkPosesResponse* response);

void SampleAnswersToProto(const collision::PointColumns& answers, const AnswerContext& context,
                          v1::SamplePointsResponse* response);

}  // namespace cwm::server
