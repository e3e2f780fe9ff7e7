"""The enumerations of the API that the fake holds, with their integers."""

from __future__ import annotations

from .base import enumeration

Curve3DTypes = enumeration(
    "adsk.core",
    "Curve3DTypes",
    {
        "Line3DCurveType": 0,
        "Arc3DCurveType": 1,
        "Circle3DCurveType": 2,
        "Ellipse3DCurveType": 3,
        "EllipticalArc3DCurveType": 4,
        "InfiniteLine3DCurveType": 5,
        "NurbsCurve3DCurveType": 6,
        "Polyline3DCurveType": 7,
    },
)
SurfaceTypes = enumeration(
    "adsk.core",
    "SurfaceTypes",
    {
        "PlaneSurfaceType": 0,
        "CylinderSurfaceType": 1,
        "ConeSurfaceType": 2,
        "SphereSurfaceType": 3,
        "TorusSurfaceType": 4,
        "EllipticalCylinderSurfaceType": 5,
        "EllipticalConeSurfaceType": 6,
        "NurbsSurfaceType": 7,
    },
)
ValueTypes = enumeration(
    "adsk.core",
    "ValueTypes",
    {
        "StringValueType": 0,
        "RealValueType": 1,
        "ObjectValueType": 2,
        "BooleanValueType": 3,
    },
)
DialogResults = enumeration(
    "adsk.core",
    "DialogResults",
    {
        "DialogError": -1,
        "DialogOK": 0,
        "DialogCancel": 1,
        "DialogYes": 2,
        "DialogNo": 3,
    },
)
MessageBoxButtonTypes = enumeration(
    "adsk.core",
    "MessageBoxButtonTypes",
    {
        "OKButtonType": 0,
        "OKCancelButtonType": 1,
        "RetryCancelButtonType": 2,
        "YesNoButtonType": 3,
        "YesNoCancelButtonType": 4,
    },
)
MessageBoxIconTypes = enumeration(
    "adsk.core",
    "MessageBoxIconTypes",
    {
        "NoIconIconType": 0,
        "QuestionIconType": 1,
        "InformationIconType": 2,
        "WarningIconType": 3,
        "CriticalIconType": 4,
    },
)
LogLevels = enumeration(
    "adsk.core",
    "LogLevels",
    {
        "ErrorLogLevel": 0,
        "WarningLogLevel": 1,
        "InfoLogLevel": 2,
    },
)
LogTypes = enumeration(
    "adsk.core",
    "LogTypes",
    {
        "FileLogType": 0,
        "ConsoleLogType": 1,
    },
)
DropDownStyles = enumeration(
    "adsk.core",
    "DropDownStyles",
    {
        "LabeledIconDropDownStyle": 0,
        "TextListDropDownStyle": 1,
        "CheckBoxDropDownStyle": 2,
    },
)
TablePresentationStyles = enumeration(
    "adsk.core",
    "TablePresentationStyles",
    {
        "nameValueTablePresentationStyle": 0,
        "itemBorderTablePresentationStyle": 1,
        "transparentBackgroundTablePresentationStyle": 2,
    },
)
CommandTerminationReason = enumeration(
    "adsk.core",
    "CommandTerminationReason",
    {
        "UnknownTerminationReason": 0,
        "CompletedTerminationReason": 1,
        "CancelledTerminationReason": 2,
        "AbortedTerminationReason": 3,
        "PreEmptedTerminationReason": 4,
        "SessionEndingTerminationReason": 5,
    },
)
DefaultModelingOrientations = enumeration(
    "adsk.core",
    "DefaultModelingOrientations",
    {
        "YUpModelingOrientation": 0,
        "ZUpModelingOrientation": 1,
    },
)
PaletteDockingStates = enumeration(
    "adsk.core",
    "PaletteDockingStates",
    {
        "PaletteDockStateFloating": 0,
        "PaletteDockStateTop": 1,
        "PaletteDockStateBottom": 2,
        "PaletteDockStateLeft": 3,
        "PaletteDockStateRight": 4,
    },
)
PaletteDockingOptions = enumeration(
    "adsk.core",
    "PaletteDockingOptions",
    {
        "PaletteDockOptionsNone": 0,
        "PaletteDockOptionsToVerticalOnly": 1,
        "PaletteDockOptionsToHorizontalOnly": 2,
        "PaletteDockOptionsToVerticalAndHorizontal": 3,
    },
)
HorizontalAlignments = enumeration(
    "adsk.core",
    "HorizontalAlignments",
    {
        "LeftHorizontalAlignment": 0,
        "CenterHorizontalAlignment": 1,
        "RightHorizontalAlignment": 2,
    },
)
VerticalAlignments = enumeration(
    "adsk.core",
    "VerticalAlignments",
    {
        "TopVerticalAlignment": 0,
        "MiddleVerticalAlignment": 1,
        "BottomVerticalAlignment": 2,
    },
)
KeyCodes = enumeration(
    "adsk.core",
    "KeyCodes",
    {
        "EscapeKeyCode": 16777216,
        "TabKeyCode": 16777217,
        "ReturnKeyCode": 16777220,
        "EnterKeyCode": 16777221,
        "DeleteKeyCode": 16777223,
    },
)
KeyboardModifiers = enumeration(
    "adsk.core",
    "KeyboardModifiers",
    {
        "NoKeyboardModifier": 0,
        "ShiftKeyboardModifier": 33554432,
        "CtrlKeyboardModifier": 67108864,
        "AltKeyboardModifier": 134217728,
        "MetaKeyboardModifier": 268435456,
    },
)
OperatingSystems = enumeration(
    "adsk.core",
    "OperatingSystems",
    {
        "WindowsOperatingSystem": 0,
        "MacOperatingSystem": 1,
        "WindowsAndMacOperatingSystem": 2,
    },
)
UserInterfaceThemes = enumeration(
    "adsk.core",
    "UserInterfaceThemes",
    {
        "ClassicUserInterfaceTheme": 0,
        "LightGrayUserInterfaceTheme": 1,
        "DarkBlueUserInterfaceTheme": 2,
        "DarkGrayUserInterfaceTheme": 3,
        "DeviceUserInterfaceTheme": 4,
    },
)
MassUnits = enumeration(
    "adsk.core",
    "MassUnits",
    {
        "GramMassUnits": 0,
        "KilogramMassUnits": 1,
        "PoundMassUnits": 2,
        "OunceMassUnits": 3,
        "TonMassUnits": 4,
        "SlugMassUnits": 5,
    },
)
CalculationAccuracy = enumeration(
    "adsk.fusion",
    "CalculationAccuracy",
    {
        "LowCalculationAccuracy": 0,
        "MediumCalculationAccuracy": 1,
        "HighCalculationAccuracy": 2,
        "VeryHighCalculationAccuracy": 3,
    },
)
DesignTypes = enumeration(
    "adsk.fusion",
    "DesignTypes",
    {
        "DirectDesignType": 0,
        "ParametricDesignType": 1,
    },
)
DesignIntentTypes = enumeration(
    "adsk.fusion",
    "DesignIntentTypes",
    {
        "PartDesignIntentType": 0,
        "AssemblyDesignIntentType": 1,
        "HybridDesignIntentType": 2,
    },
)
FeatureHealthStates = enumeration(
    "adsk.fusion",
    "FeatureHealthStates",
    {
        "HealthyFeatureHealthState": 0,
        "WarningFeatureHealthState": 1,
        "ErrorFeatureHealthState": 2,
        "SuppressedFeatureHealthState": 3,
        "RolledBackFeatureHealthState": 4,
        "UnknownFeatureHealthState": 5,
    },
)
JointDirections = enumeration(
    "adsk.fusion",
    "JointDirections",
    {
        "XAxisJointDirection": 0,
        "YAxisJointDirection": 1,
        "ZAxisJointDirection": 2,
        "CustomJointDirection": 3,
    },
)
JointGeometryTypes = enumeration(
    "adsk.fusion",
    "JointGeometryTypes",
    {
        "JointConstructionPointGeometry": 0,
        "JointSketchPointGeometry": 1,
        "JointBRepVertexGeometry": 2,
        "JointBRepEdgeGeometry": 3,
        "JointSketchCurveGeometry": 4,
        "JointProfileGeometry": 5,
        "JointPlanarBRepFaceGeometry": 6,
        "JointNonPlanarBRepFaceGeometry": 7,
        "JointBetweenTwoPlanesGeometry": 8,
        "JointByTwoEdgeIntersectionGeometry": 9,
        "JointTangentBRepFaceGeometry": 10,
        "JointTangentBRepFaceEdgeGeometry": 11,
    },
)
JointKeyPointTypes = enumeration(
    "adsk.fusion",
    "JointKeyPointTypes",
    {
        "StartKeyPoint": 0,
        "MiddleKeyPoint": 1,
        "EndKeyPoint": 2,
        "CenterKeyPoint": 3,
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
CustomGraphicsPointTypes = enumeration(
    "adsk.fusion",
    "CustomGraphicsPointTypes",
    {
        "UserDefinedCustomGraphicsPointType": 0,
        "PointCloudCustomGraphicsPointType": 1,
    },
)
CustomGraphicsBillBoardStyles = enumeration(
    "adsk.fusion",
    "CustomGraphicsBillBoardStyles",
    {
        "ScreenBillBoardStyle": 1,
        "AxialBillBoardStyle": 2,
        "RightReadingBillBoardStyle": 3,
    },
)
CustomGraphicsCullModes = enumeration(
    "adsk.fusion",
    "CustomGraphicsCullModes",
    {
        "CustomGraphicsCullFront": 0,
        "CustomGraphicsCullBack": 1,
        "CustomGraphicsCullNone": 2,
    },
)
BRepEntityTypes = enumeration(
    "adsk.fusion",
    "BRepEntityTypes",
    {
        "BRepBodyEntityType": 0,
        "BRepFaceEntityType": 1,
        "BRepEdgeEntityType": 2,
        "BRepVertexEntityType": 3,
    },
)
UnitSystems = enumeration(
    "adsk.fusion",
    "UnitSystems",
    {
        "CustomUnitSystem": 0,
        "MillimeterGramUnitSystem": 1,
        "CentimeterGramUnitSystem": 2,
        "MeterKilogramUnitSystem": 3,
        "InchOunceUnitSystem": 4,
        "FootPoundUnitSystem": 5,
    },
)
MeshUnits = enumeration(
    "adsk.fusion",
    "MeshUnits",
    {
        "CentimeterMeshUnit": 0,
        "MillimeterMeshUnit": 1,
        "MeterMeshUnit": 2,
        "InchMeshUnit": 3,
        "FootMeshUnit": 4,
    },
)
DistanceUnits = enumeration(
    "adsk.fusion",
    "DistanceUnits",
    {
        "MillimeterDistanceUnits": 0,
        "CentimeterDistanceUnits": 1,
        "MeterDistanceUnits": 2,
        "InchDistanceUnits": 3,
        "FootDistanceUnits": 4,
        "YardDistanceUnits": 5,
        "MicronDistanceUnits": 6,
        "HectometerDistanceUnits": 7,
        "MileDistanceUnits": 8,
        "MilDistanceUnits": 9,
        "NauticalMileDistanceUnits": 10,
    },
)
