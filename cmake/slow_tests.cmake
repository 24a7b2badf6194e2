# The test suites that `make test-fast` leaves out: those that take more than about three seconds in the release build,
# all tests of the suite together. A new test is fast unless its suite is named here; if `make test-fast` then takes a
# minute or more on two cores, the suite belongs here.
set(slow_suites
    AllocationTest
    ArmsTest
    Calibrate
    CalibrateTest
    Check
    DriveToTheWall
    EdgesElsewhere
    Episode
    FallTest
    FlowTest
    FollowCheckRunsTest
    FuzzTest
    MotorHeatTest
    NavigatorTest
    Operate
    PictureTest
    Recall
    RecallByEdges
    RecallInPhysics
    Replay
    Reproduce
    RetracePartTest
    RobotsStates
    Scenario
    SensorCheckRunsTest
    Session
    ShadowTest
    Soak
    StopTest)
# As a filter of GoogleTest: the suites, and their instances for each robot.
list(TRANSFORM slow_suites REPLACE "(.+)" "\\1.*:*/\\1.*" OUTPUT_VARIABLE slow_tests)
list(JOIN slow_tests ":" slow_tests)
