"""One function per renderer: (pieces, cameras) -> draw(cameras) -> a list of HxWx3 or HxWx4 arrays, top row first."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from world import SIZE, SUN, Piece

WIDTH, HEIGHT = SIZE


def _panda3d(pipe: str):
    def make(pieces: list[Piece], cameras):
        from panda3d import core

        core.load_prc_file_data("", f"load-display {pipe}\nwindow-type offscreen\naudio-library-name null\nnotify-level error\ntextures-power-2 none\n")
        from direct.showbase.ShowBase import ShowBase

        base = ShowBase(windowType="offscreen")
        layout = core.GeomVertexFormat.get_v3n3t2()
        for piece in pieces:
            data = core.GeomVertexData("piece", layout, core.Geom.UH_static)
            data.unclean_set_num_rows(len(piece.positions))
            rows = np.hstack([piece.positions, piece.normals, piece.uv]).astype(np.float32)
            assert layout.get_array(0).get_stride() == rows.shape[1] * 4
            memoryview(data.modify_array(0)).cast("B")[:] = rows.tobytes()
            triangles = core.GeomTriangles(core.Geom.UH_static)
            triangles.set_index_type(core.Geom.NT_uint32)
            indices = triangles.modify_vertices()
            indices.unclean_set_num_rows(piece.faces.size)
            memoryview(indices).cast("B")[:] = piece.faces.astype(np.uint32).tobytes()
            geom = core.Geom(data)
            geom.add_primitive(triangles)
            node = core.GeomNode("piece")
            node.add_geom(geom)
            path = base.render.attach_new_node(node)
            material = core.Material()
            material.set_diffuse((*piece.color, 1))
            material.set_ambient((*piece.color, 1))
            path.set_material(material)
            if piece.image is not None:
                texture = core.Texture()
                texture.setup_2d_texture(piece.image.width, piece.image.height, core.Texture.T_unsigned_byte, core.Texture.F_rgb)
                texture.set_ram_image_as(np.ascontiguousarray(np.asarray(piece.image)[::-1]).tobytes(), "RGB")
                texture.set_minfilter(core.SamplerState.FT_linear_mipmap_nearest)
                texture.set_magfilter(core.SamplerState.FT_linear)
                path.set_texture(texture)
        sun = core.DirectionalLight("sun")
        sun.set_color((0.34, 0.33, 0.31, 1))
        sun.set_direction(core.LVector3(*SUN))
        ambient = core.AmbientLight("ambient")
        ambient.set_color((0.85, 0.83, 0.8, 1))
        for light in (sun, ambient):
            base.render.set_light(base.render.attach_new_node(light))
        eyes, textures = [], []
        for i, camera in enumerate(cameras):
            buffer = base.graphicsEngine.make_output(
                base.pipe, f"buffer{i}", 0, core.FrameBufferProperties(core.FrameBufferProperties.get_default()), core.WindowProperties.size(WIDTH, HEIGHT),
                core.GraphicsPipe.BF_refuse_window, base.win.get_gsg(), base.win)
            assert buffer is not None
            texture = core.Texture()
            buffer.add_render_texture(texture, core.GraphicsOutput.RTM_copy_ram)
            buffer.set_clear_color((0.75, 0.83, 0.92, 1))
            lens = core.PerspectiveLens()
            lens.set_aspect_ratio(WIDTH / HEIGHT)
            lens.set_min_fov(camera.vfov_deg)
            lens.set_near_far(0.05, 200)
            eye = base.render.attach_new_node(core.Camera(f"eye{i}", lens))
            buffer.make_display_region().set_camera(eye)
            eyes.append(eye)
            textures.append(texture)

        def draw(now):
            for eye, camera in zip(eyes, now):
                eye.set_pos(*camera.eye)
                eye.look_at(*camera.target)
            base.graphicsEngine.render_frame()
            pictures = []
            for texture in textures:
                flat = np.frombuffer(texture.get_ram_image(), np.uint8).reshape(HEIGHT, WIDTH, -1)
                pictures.append(flat[::-1, :, 2::-1])
            return pictures

        return draw

    return make


def _pyrender(pieces: list[Piece], cameras):
    import pyrender

    scene = pyrender.Scene(ambient_light=[0.8, 0.8, 0.8], bg_color=[0.75, 0.83, 0.92])
    for piece in pieces:
        texture = None if piece.image is None else pyrender.Texture(source=piece.image, source_channels="RGB")
        material = pyrender.MetallicRoughnessMaterial(baseColorFactor=[*piece.color, 1], baseColorTexture=texture, metallicFactor=0, roughnessFactor=1)
        primitive = pyrender.Primitive(piece.positions, piece.normals, texcoord_0=piece.uv, indices=piece.faces, material=material)
        scene.add(pyrender.Mesh([primitive]))
    light = np.eye(4)
    light[:3, 2] = -SUN
    light[:3, 0] = np.cross([0, 0, 1], -SUN) / np.linalg.norm(np.cross([0, 0, 1], -SUN))
    light[:3, 1] = np.cross(light[:3, 2], light[:3, 0])
    scene.add(pyrender.DirectionalLight(color=np.ones(3), intensity=1.0), pose=light)
    renderer = pyrender.OffscreenRenderer(WIDTH, HEIGHT)
    node = scene.add(pyrender.PerspectiveCamera(yfov=1.0, znear=0.05, zfar=200))

    def draw(now):
        pictures = []
        for camera in now:
            node.camera.yfov = np.radians(camera.vfov_deg)
            scene.set_pose(node, camera.world_from_camera())
            pictures.append(renderer.render(scene)[0])
        return pictures

    return draw


def _mujoco(pieces: list[Piece], cameras):
    import mujoco

    folder = tempfile.TemporaryDirectory()
    assets, geoms = [], []
    for i, piece in enumerate(pieces):
        lines = [f"v {x} {y} {z}" for x, y, z in piece.positions] + [f"vt {u} {v}" for u, v in piece.uv] + [f"vn {x} {y} {z}" for x, y, z in piece.normals]
        lines += ["f " + " ".join(f"{k}/{k}/{k}" for k in face + 1) for face in piece.faces]
        (Path(folder.name) / f"{i}.obj").write_text("\n".join(lines))
        assets.append(f'<mesh name="m{i}" file="{i}.obj" inertia="shell"/>')
        texture = ""
        if piece.image is not None:
            piece.image.save(Path(folder.name) / f"{i}.png")
            assets.append(f'<texture name="t{i}" type="2d" file="{i}.png"/>')
            texture = f'texture="t{i}"'
        color = " ".join(map(str, (*piece.color, 1)))
        assets.append(f'<material name="a{i}" {texture} rgba="{color}" specular="0"/>')
        geoms.append(f'<geom type="mesh" mesh="m{i}" material="a{i}" contype="0" conaffinity="0"/>')
    eyes = "".join(f'<camera name="c{i}" fovy="{camera.vfov_deg}"/>' for i, camera in enumerate(cameras))
    xml = (f'<mujoco><compiler meshdir="{folder.name}" texturedir="{folder.name}"/><visual><headlight active="0"/><global offwidth="{WIDTH}" offheight="{HEIGHT}"/><map znear="0.001" zfar="10"/>'
           f'<quality shadowsize="0" offsamples="0"/></visual><asset>{"".join(assets)}</asset><worldbody><light directional="true" castshadow="false" dir="{SUN[0]} {SUN[1]} {SUN[2]}" '
           f'ambient="0.8 0.8 0.8" diffuse="0.34 0.33 0.31" specular="0 0 0"/>{"".join(geoms)}{eyes}</worldbody></mujoco>')
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer = mujoco.Renderer(model, HEIGHT, WIDTH, max_geom=len(pieces) + 10)

    def draw(now):
        pictures = []
        for i, camera in enumerate(now):
            pose = camera.world_from_camera()
            data.cam_xpos[i] = pose[:3, 3]
            data.cam_xmat[i] = pose[:3, :3].ravel()
            renderer.update_scene(data, camera=i)
            pictures.append(renderer.render())
        return pictures

    return draw


def _vtk(pieces: list[Piece], cameras):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0.75, 0.83, 0.92)
    renderer.SetAutomaticLightCreation(False)
    sun = vtk.vtkLight()
    sun.SetPositional(False)
    sun.SetPosition(*(-SUN))
    sun.SetFocalPoint(0, 0, 0)
    sun.SetIntensity(0.34)
    renderer.AddLight(sun)
    for piece in pieces:
        mesh = vtk.vtkPolyData()
        points = vtk.vtkPoints()
        points.SetData(numpy_to_vtk(piece.positions, deep=True))
        mesh.SetPoints(points)
        cells = vtk.vtkCellArray()
        threes = np.hstack([np.full((len(piece.faces), 1), 3), piece.faces]).astype(np.int64).ravel()
        cells.SetCells(len(piece.faces), numpy_to_vtkIdTypeArray(threes, deep=True))
        mesh.SetPolys(cells)
        mesh.GetPointData().SetNormals(numpy_to_vtk(piece.normals, deep=True))
        mesh.GetPointData().SetTCoords(numpy_to_vtk(piece.uv, deep=True))
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputData(mesh)
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*piece.color)
        actor.GetProperty().SetAmbient(0.8)
        if piece.image is not None:
            data = vtk.vtkImageData()
            data.SetDimensions(piece.image.width, piece.image.height, 1)
            data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(np.asarray(piece.image)[::-1]).reshape(-1, 3), deep=True))
            texture = vtk.vtkTexture()
            texture.SetInputData(data)
            texture.InterpolateOn()
            texture.MipmapOn()
            texture.RepeatOn()
            actor.SetTexture(texture)
        renderer.AddActor(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(WIDTH, HEIGHT)
    window.AddRenderer(renderer)
    eye = renderer.GetActiveCamera()
    pixels = vtk.vtkUnsignedCharArray()

    def draw(now):
        pictures = []
        for camera in now:
            eye.SetPosition(*camera.eye)
            eye.SetFocalPoint(*camera.target)
            eye.SetViewUp(0, 0, 1)
            eye.SetViewAngle(camera.vfov_deg)
            eye.SetClippingRange(0.05, 200)
            window.Render()
            window.GetPixelData(0, 0, WIDTH - 1, HEIGHT - 1, 0, pixels, 0)
            pictures.append(vtk_to_numpy(pixels).reshape(HEIGHT, WIDTH, 3)[::-1].copy())
        return pictures

    return draw


ALL = {"panda3d": _panda3d("p3headlessgl"), "panda3d-tiny": _panda3d("p3tinydisplay"), "mujoco": _mujoco, "pyrender": _pyrender, "vtk": _vtk}
