/* joint/joints.c - the list of joint types. */
#include "solve/joint_type.h"

extern const JointType joint_hinge, joint_slider, joint_ball, joint_weld, joint_distance, joint_rope, joint_spring, joint_gear,
    joint_rack, joint_wheel, joint_bolt, joint_motor, joint_strut, joint_beam, joint_guide;

const JointType *const joint_types[] = {
    &joint_hinge, &joint_slider, &joint_ball, &joint_weld, &joint_distance, &joint_rope, &joint_spring, &joint_gear,
    &joint_rack, &joint_wheel, &joint_bolt, &joint_motor, &joint_strut, &joint_beam, &joint_guide, NULL,
};
