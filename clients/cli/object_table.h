// Prints objects as tables.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "clients/cli/table.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

// E.g. "cylinder r 33.1 mm, l 101.0 mm".
std::string FormatShape(const cwm::v1::ShapePart& part);

// E.g. "moving, visible, carried by panda/panda_hand".
std::string FormatFacts(const cwm::v1::SensorFacts& facts);

// An object with its label in the labelled cloud; -1: no column of labels.
struct LabelledObject {
  const cwm::v1::Object* object = nullptr;
  int label = -1;
};

// One line per part: name, kind, shape, quality of the fit, size, support, position, with the
// coefficients below.
void PrintObjects(const std::vector<LabelledObject>& objects, TableStyle style, std::ostream& out);
void PrintObjects(const google::protobuf::RepeatedPtrField<cwm::v1::Object>& objects,
                  TableStyle style, std::ostream& out);

// Prints all facts about one object.
void PrintObjectDetails(const cwm::v1::Object& object, TableStyle style, std::ostream& out);

}  // namespace cwm::cli
