// A robot whose motions can be checked by hand.
#pragma once

namespace cwm::testing {

// A ball at the origin and two links of 0.5 m that turn about z, each with a ball of 0.1 m radius
// at its end.
inline constexpr char kTwoLinkArm[] = R"(<robot name="arm">
<link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="upper">
<collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="hand">
<collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="hand"/><origin xyz="0.5 0 0"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint></robot>
)";

}  // namespace cwm::testing
