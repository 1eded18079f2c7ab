//! `visualization_msgs`, as of ROS 2 Humble.

use super::geometry::{POINT, POSE, Point, Pose, VECTOR3, Vector3};
use super::message;
use super::sensor::{COMPRESSED_IMAGE, CompressedImage};
use super::standard::{COLOR, ColorRGBA, DURATION, HEADER, Header};
use crate::definition::Definition;
use crate::time::Duration;
use serde::{Deserialize, Serialize};

/// A position in an image, from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are said above")]
pub struct UVCoordinate {
    pub u: f32,
    pub v: f32,
}

pub static UV_COORDINATE: Definition =
    Definition { name: "visualization_msgs/msg/UVCoordinate", text: "float32 u\nfloat32 v\n", parts: &[] };

/// The file of a mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct MeshFile {
    pub filename: String,
    pub data: Vec<u8>,
}

pub static MESH_FILE: Definition =
    Definition { name: "visualization_msgs/msg/MeshFile", text: "string filename\nuint8[] data\n", parts: &[] };

/// A shape in a display of the map.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Marker {
    pub header: Header,
    /// Namespace; a later marker with the same namespace and `id` replaces this one.
    pub ns: String,
    /// Identifier in the namespace.
    pub id: i32,
    /// Kind of shape: [`Marker::SPHERE`] or another value of the definition.
    #[serde(rename = "type")]
    pub shape: i32,
    /// [`Marker::ADD`] or [`Marker::DELETE_ALL`].
    pub action: i32,
    pub pose: Pose,
    /// Its size along its own axes, m.
    pub scale: Vector3,
    pub color: ColorRGBA,
    /// Duration; 0: unlimited.
    pub lifetime: Duration,
    /// Whether it moves with its frame.
    pub frame_locked: bool,
    /// Vertices of lines, m.
    pub points: Vec<Point>,
    /// Colours of the vertices.
    pub colors: Vec<ColorRGBA>,
    pub texture_resource: String,
    /// The texture as an image in the message.
    pub texture: CompressedImage,
    /// Coordinates in the texture.
    pub uv_coordinates: Vec<UVCoordinate>,
    pub text: String,
    /// A mesh by its resource.
    pub mesh_resource: String,
    pub mesh_file: MeshFile,
    /// Whether the materials of the mesh are used.
    pub mesh_use_embedded_materials: bool,
}

impl Marker {
    /// An arrow along x.
    pub const ARROW: i32 = 0;
    /// An ellipsoid.
    pub const SPHERE: i32 = 2;
    /// Adds the marker, or replaces one with the same namespace and identifier.
    pub const ADD: i32 = 0;
    pub const DELETE_ALL: i32 = 3;
}

pub static MARKER: Definition = Definition {
    name: "visualization_msgs/msg/Marker",
    text: "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\n\
           int32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n\
           int32 TRIANGLE_LIST=11\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n\
           std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n\
           geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\nbool frame_locked\n\
           geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n\
           sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n\
           string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
    parts: &[&HEADER, &POSE, &VECTOR3, &COLOR, &DURATION, &POINT, &COMPRESSED_IMAGE, &UV_COORDINATE, &MESH_FILE],
};

/// Shapes in a display of the map.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MarkerArray {
    pub markers: Vec<Marker>,
}

message!(
    MarkerArray,
    MARKER_ARRAY = "visualization_msgs/msg/MarkerArray",
    "visualization_msgs/Marker[] markers\n",
    [MARKER]
);
