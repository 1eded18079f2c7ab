//! `visualization_msgs`, as of ROS 2 Humble.

use super::geometry::{Point, Pose, Vector3};
use super::sensor::CompressedImage;
use super::standard::{ColorRGBA, Header};
use crate::definition::messages;
use crate::time::Duration;

messages! {
    "visualization_msgs"
    /// A position in an image, from 0 to 1.
    #[derive(Copy, Default)]
    UVCoordinate { u: f32, v: f32, }

    /// The file of a mesh.
    #[derive(Default)]
    MeshFile { filename: String, data: Vec<u8>, }

    /// A shape in a display of the map.
    #[derive(Default)]
    Marker {
        "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\n\
         int32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n\
         int32 TRIANGLE_LIST=11\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n"
        header: Header,
        /// Namespace; a later marker with the same namespace and `id` replaces this one.
        ns: String,
        id: i32,
        /// [`Marker::SPHERE`] or another value of the definition.
        r#type: i32,
        /// [`Marker::ADD`] or [`Marker::DELETE_ALL`].
        action: i32,
        pose: Pose,
        /// Its size along its own axes, m.
        scale: Vector3,
        color: ColorRGBA,
        /// 0: unlimited.
        lifetime: Duration,
        /// Whether it moves with its frame.
        frame_locked: bool,
        /// Vertices of lines, m, and their colours.
        points: Vec<Point>,
        colors: Vec<ColorRGBA>,
        /// A texture by its resource, or in the message.
        texture_resource: String,
        texture: CompressedImage,
        uv_coordinates: Vec<UVCoordinate>,
        text: String,
        /// A mesh by its resource, or in the message.
        mesh_resource: String,
        mesh_file: MeshFile,
        mesh_use_embedded_materials: bool,
    }

    /// Shapes in a display of the map.
    #[derive(Default)]
    MarkerArray { markers: Vec<Marker>, }
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
