<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis version="3.22" styleCategories="Symbology|Labeling|MapTips" labelsEnabled="1">
 <renderer-v2 type="categorizedSymbol" attr="status" symbollevels="0" enableorderby="0" forceraster="0">
  <categories>
   <category symbol="0" value="ok" label="ok" render="true"/>
   <category symbol="1" value="weak" label="weak" render="true"/>
   <category symbol="2" value="failed" label="failed" render="true"/>
  </categories>
  <symbols>
   <symbol type="marker" name="0" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleMarker" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="name" value="cross"/>
      <Option type="QString" name="color" value="44,122,87,255"/>
      <Option type="QString" name="outline_color" value="44,122,87,255"/>
      <Option type="QString" name="size" value="4"/>
      <Option type="QString" name="size_unit" value="MM"/>
     </Option>
    </layer>
   </symbol>
   <symbol type="marker" name="1" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleMarker" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="name" value="cross"/>
      <Option type="QString" name="color" value="168,106,0,255"/>
      <Option type="QString" name="outline_color" value="168,106,0,255"/>
      <Option type="QString" name="size" value="5"/>
      <Option type="QString" name="size_unit" value="MM"/>
     </Option>
    </layer>
   </symbol>
   <symbol type="marker" name="2" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleMarker" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="name" value="cross"/>
      <Option type="QString" name="color" value="179,54,43,255"/>
      <Option type="QString" name="outline_color" value="179,54,43,255"/>
      <Option type="QString" name="size" value="5"/>
      <Option type="QString" name="size_unit" value="MM"/>
     </Option>
    </layer>
   </symbol>
  </symbols>
 </renderer-v2>
 <labeling type="simple">
  <settings calloutType="simple">
   <text-style fieldName="name" isExpression="0" fontFamily="Sans" fontSize="8" textColor="34,40,47,255">
    <text-buffer bufferDraw="1" bufferSize="0.8" bufferColor="255,255,255,255" bufferSizeUnits="MM"/>
   </text-style>
   <placement placement="6" dist="1"/>
   <rendering scaleVisibility="0" obstacle="1"/>
  </settings>
 </labeling>
 <mapTip>&lt;b&gt;[% "name" %]&lt;/b&gt;: [% "status" %]&lt;br&gt;[% coalesce("message", '') %]&lt;br&gt;[% "matched" %] of [% "searched" %] patches matched&lt;br&gt;[% if("picture" is not null, '&lt;img width="400" src="file://' || file_path(layer_property(@layer, 'path')) || '/' || "picture" || '"&gt;', '') %]&lt;br&gt;&lt;a href="file://[% file_path(layer_property(@layer, 'path')) %]/report.html"&gt;report&lt;/a&gt;</mapTip>
</qgis>
