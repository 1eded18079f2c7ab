//! Parameters, arguments and names: read from files and command lines, and written back.

use scphd_node::middleware::Arguments;
use scphd_node::parameters::{ParameterError, Parameters, Value};
use scphd_node::setup::Setup;
use scphd_vehicle::{Description, Setting};

#[test]
fn files_arguments_and_nested_names_are_read_and_written_back() {
    let mut read = Parameters::default();
    let text = "/**:\n  ros__parameters:\n    a: 1\nscphd:\n  ros__parameters:\n    a: 2.5\n    b: {c: yes, d: [x, y]}\n\
                other:\n  ros__parameters: {a: 3}\n";
    read.read(text, "scphd").unwrap();
    read.assign("e.f:=.inf").unwrap();
    read.assign("g:='a word'").unwrap();
    assert_eq!(read.0["a"], Value::Number(2.5));
    assert_eq!(read.0["b.d"], Value::Texts(vec!["x".into(), "y".into()]));
    assert_eq!(read.0["e.f"], Value::Number(f64::INFINITY));
    let mut again = Parameters::default();
    again.read(&read.text("scphd"), "scphd").unwrap();
    assert_eq!(again, read);
}

#[test]
fn an_invalid_parameter_file_is_an_error() {
    for text in
        ["", "[1]", "scphd: 3", "other:\n  ros__parameters: {a: 1}", "scphd:\n  ros__parameters: {a: [1]}", "a: ["]
    {
        assert!(Parameters::default().read(text, "scphd").is_err(), "{text}");
    }
    assert!(Parameters::default().assign("a=1").is_err());
}

#[test]
fn names_are_resolved_as_by_ros() {
    let words = "-r __ns:=/car --ros-args -r scan:=/lidar/points -r __node:=slam -p order.wait_s:=0.5 log --flag";
    let found = Arguments::of(words.split(' ').map(str::to_owned), "scphd").unwrap();
    assert_eq!((found.resolved("scan"), found.resolved("odom")), ("/lidar/points".into(), "/car/odom".into()));
    assert_eq!((found.resolved("~/pose"), found.resolved("/tf")), ("/car/slam/pose".into(), "/tf".into()));
    assert_eq!(found.rest, ["log", "--flag"]);
    assert!(found.parameters.0.contains_key("order.wait_s"));
    assert!(Arguments::of(["-p".to_owned()].into_iter(), "scphd").is_err());
}

fn setup(words: &[&str]) -> Result<Setup, ParameterError> {
    let mut parameters = Parameters::default();
    words.iter().try_for_each(|word| parameters.assign(word))?;
    Setup::of(&parameters)
}

#[test]
fn settings_are_read_by_name_in_any_order() {
    let said = setup(&[
        "sensors:=[front, rear]",
        "sensor.front.range_max_m:=12.5",
        "sensor.rear.yaw_rad:=3.0",
        "sensor.rear.topic:=/rear/clusters",
        "joint.movers:=yes",
        "noise.speed_sigma_mps:=0.25",
    ])
    .unwrap();
    let [front, rear, ..] = said.description.sensors;
    assert_eq!((front.unwrap().window.range_max_m, rear.unwrap().yaw_rad), (12.5, 3.0));
    assert_eq!(said.description.vehicle.noise.speed_sigma_mps, 0.25);
    assert_eq!(said.wiring.sensors[0].topic.name, "detections/front");
    assert_eq!(said.wiring.sensors[1].topic.name, "/rear/clusters");
    assert!(said.description.check().is_ok());
    assert_eq!([0, 1].map(|place: usize| said.wiring.sensors[place].seated), [false, true]);
}

#[test]
fn written_parameters_are_read_back() {
    let said = setup(&[
        "sensor.model:=range_bearing", "sensor.left_m:=0.5", "position:=yes", "order.wait_s:=0.1", "joint.movers:=yes",
    ])
    .unwrap();
    let mut description = Description::<f64>::robot();
    for setting in Setting::all() {
        if let Some(number) = said.description.get(setting, 0) {
            description.set(setting, 0, f64::from(number)).unwrap();
        }
    }
    let mut written = Parameters::default();
    written.read(&Setup::parameters(&description, &said.wiring).text("scphd"), "scphd").unwrap();
    assert_eq!(Setup::of(&written).unwrap(), said);
}

#[test]
fn invalid_parameters_are_named() {
    for (word, part) in [
        ("sensor.range_max_m:=-1", "above 0"),
        ("vehicle.kind:=boat", "one of ackermann"),
        ("speed:=1", "no parameter 'speed'"),
        ("odometry.type:=std_msgs/msg/String", "nav_msgs/msg/Odometry"),
        ("order.gap_s:=-1", "between 0"),
        ("sensor.left.range_max_m:=1", "'sensors' has the names"),
    ] {
        let error = setup(&[word]).unwrap_err().to_string();
        assert!(error.contains(part), "{word}: {error}");
    }
}
