"""Enumerations of the API that the add-in and its tests use, with their values."""

from __future__ import annotations

from .base import enumeration

DialogResults = enumeration(
    "adsk.core", "DialogResults", {"DialogOK": 0, "DialogCancel": 1, "DialogYes": 2, "DialogNo": 3}
)
MessageBoxButtonTypes = enumeration("adsk.core", "MessageBoxButtonTypes", {"YesNoButtonType": 3})
MessageBoxIconTypes = enumeration("adsk.core", "MessageBoxIconTypes", {"WarningIconType": 3})
LogLevels = enumeration("adsk.core", "LogLevels", {"ErrorLogLevel": 0})
LogTypes = enumeration("adsk.core", "LogTypes", {"FileLogType": 0, "ConsoleLogType": 1})
DropDownStyles = enumeration(
    "adsk.core", "DropDownStyles", {"TextListDropDownStyle": 1, "CheckBoxDropDownStyle": 2}
)
CalculationAccuracy = enumeration(
    "adsk.fusion",
    "CalculationAccuracy",
    {"HighCalculationAccuracy": 2, "VeryHighCalculationAccuracy": 3},
)
JointMotionTypes = enumeration(
    "adsk.fusion",
    "JointMotionTypes",
    {
        "BallJointPitchMotionType": 0,
        "BallJointRollMotionType": 1,
        "BallJointYawMotionType": 2,
        "CylindricalJointRotateMotionType": 3,
        "CylindricalJointSlideMotionType": 4,
        "PinSlotJointRotateMotionType": 5,
        "PinSlotJointSlideMotionType": 6,
        "PlanarJointRotateMotionType": 7,
        "PlanarJointSlideOneMotionType": 8,
        "PlanarJointSlideTwoMotionType": 9,
        "RevoluteJointRotateMotionType": 10,
        "SliderJointSlideMotionType": 11,
    },
)
DesignTypes = enumeration("adsk.fusion", "DesignTypes", {"DirectDesignType": 0})
FeatureHealthStates = enumeration(
    "adsk.fusion",
    "FeatureHealthStates",
    {
        "WarningFeatureHealthState": 1,
        "ErrorFeatureHealthState": 2,
        "RolledBackFeatureHealthState": 4,
    },
)
JointTypes = enumeration(
    "adsk.fusion",
    "JointTypes",
    {
        "RigidJointType": 0,
        "RevoluteJointType": 1,
        "SliderJointType": 2,
        "CylindricalJointType": 3,
        "PinSlotJointType": 4,
        "PlanarJointType": 5,
        "BallJointType": 6,
        "InferredJointType": 7,
    },
)
TriangleMeshQualityOptions = enumeration(
    "adsk.fusion",
    "TriangleMeshQualityOptions",
    {
        "LowQualityTriangleMesh": 8,
        "NormalQualityTriangleMesh": 11,
        "HighQualityTriangleMesh": 13,
        "VeryHighQualityTriangleMesh": 15,
    },
)
CustomGraphicsBillBoardStyles = enumeration(
    "adsk.fusion", "CustomGraphicsBillBoardStyles", {"ScreenBillBoardStyle": 1}
)
